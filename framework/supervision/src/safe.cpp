// Decides which outputs reach their readers: those of executing modules. Readers of other outputs get the
// safe value.
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

// Called with `true` before the module can write its first sample, and with `false` while it may still be
// writing its last one.
void Supervisor::trust(const Member& member, bool trusted) {
  for (const Wiring::Wire& wire : parts_.wiring.wires()) {
    if (wire.plan.from.module != member.index || !wire.plan.writer.given()) continue;
    if (trusted)
      wire.link.trust();
    else
      wire.link.withhold();
  }
}

// Checks the writing modules of samples that arrive over DDS, because in those links the gateway is the
// writer.
void Supervisor::watch_writers() {
  for (std::size_t i = 0; i < parts_.wiring.wires().size(); ++i) {
    const Wiring::Wire& wire = parts_.wiring.wires()[i];
    const model::Endpoint& writer = wire.plan.writer;
    if (!writer.given() || wire.plan.from.module) continue;
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
      wire.link.trust();
    else
      wire.link.withhold();
  }
}

}  // namespace takt::supervision
