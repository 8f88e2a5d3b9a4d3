// Decides which outputs reach their readers: only the outputs of executing modules. Readers of other outputs
// get the safe value. Also gives the gateway the known bounds of the other devices' clocks.
#include <utility>

#include <takt/supervision/supervisor.hpp>
#include "hosted.hpp"
#include "limits.hpp"
#include "member.hpp"

namespace takt::supervision {

void Supervisor::give_safe(const std::vector<model::SafeOutput>& outputs) {
  for (const model::SafeOutput& output : outputs) parts_.wiring.give_safe(output);
}

// Shuts the device down. The device also publishes `stops_cell`, for devices that do not receive the status
// of the device that failed first.
void Supervisor::stop_for(Problem problem) {
  stops_cell_ = true;
  fail_device(std::move(problem));
}

// Lets the module's samples reach their readers, or withholds them. This is called with `true` before the
// module can write its first sample, and with `false` while the module may still be writing its last sample.
void Supervisor::trust(const Member& member, bool trusted) {
  for (const Wiring::CreatedLink& created : parts_.wiring.links()) {
    if (created.plan.from.module != member.index || !created.plan.writer.given()) continue;
    if (trusted)
      created.link.trust();
    else
      created.link.withhold();
  }
}

// For each module of another device that sends samples to this device, checks whether the module executes.
// The writer of the links for these samples is the gateway, so trust() skips these links.
void Supervisor::check_writers() {
  for (std::size_t i = 0; i < parts_.wiring.links().size(); ++i) {
    const Wiring::CreatedLink& created = parts_.wiring.links()[i];
    const model::Endpoint& writer = created.plan.writer;
    if (!writer.given() || created.plan.from.module) continue;
    bool executes = false;
    if (writer.device == device().name) {
      for (const auto& member : members_) {
        if (member->model.name == writer.module)
          executes =
              member->state() == lifecycle::State::executing && (member->in_tables() || !member->scheduled());
      }
    } else {
      const auto flow = flows_ ? flows_->health(i) : std::nullopt;
      executes =
          flow && flow->matched > 0 && options_.executes && options_.executes(writer.device, writer.module);
    }
    if (executes)
      created.link.trust();
    else
      created.link.withhold();
  }
}

// Gives the gateway the clocks of the devices that send samples to this device.
void Supervisor::pass_on_clocks() {
  if (!options_.latest_clock) return;
  for (const Wiring::CreatedLink& created : parts_.wiring.links()) {
    if (created.plan.sender.empty()) continue;
    created.link.block().sender_clock_ns.store(options_.latest_clock(created.plan.sender).value_or(0),
                                               std::memory_order_relaxed);
  }
}

}  // namespace takt::supervision
