// Which outputs are to be trusted: those of modules that execute. Readers of the others get the safe value.
#include <utility>

#include <takt/node/supervisor.hpp>

namespace takt::node {

void Supervisor::give_safe(const std::vector<model::SafeOutput>& outputs) {
  for (const model::SafeOutput& output : outputs) wiring_.give_safe(output);
}

// Said on, for devices that do not hear whose fault it was.
void Supervisor::stop_for(Problem problem) {
  stops_cell_ = true;
  fail_device(std::move(problem));
}

// Before it can write the first sample of this time, or while it may be writing the last.
void Supervisor::trust(const Member& member, bool trusted) {
  for (const Wiring::Wire& wire : wiring_.wires()) {
    if (wire.plan.from.module != member.index || !wire.plan.writer.given()) continue;
    if (trusted)
      wire.link.trust();
    else
      wire.link.withhold();
  }
}

// Of what comes over DDS the gateway is the writer, and whoever wrote it is looked at from here.
void Supervisor::watch_writers() {
  for (std::size_t i = 0; i < wiring_.wires().size(); ++i) {
    const Wiring::Wire& wire = wiring_.wires()[i];
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
      const auto flow = flow_manager_ ? flow_manager_->health(i) : std::nullopt;
      executes =
          flow && flow->matched > 0 && options_.executes && options_.executes(writer.device, writer.module);
    }
    if (executes)
      wire.link.trust();
    else
      wire.link.withhold();
  }
}

}  // namespace takt::node
