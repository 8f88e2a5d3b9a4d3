#include <takt/wire/fault.hpp>

#include <takt/wire/words.hpp>

namespace takt::wire {

FaultEvent to_wire(const model::Fault& fault) {
  FaultEvent event;
  set(event.path(), path_of(fault.cell, fault.device));
  set(event.cell(), fault.cell);
  set(event.device(), fault.device);
  set(event.name(), fault.module);
  event.kind(static_cast<FaultKind>(fault.kind));
  event.severity(static_cast<FaultSeverity>(model::severity_of(fault.kind)));
  event.error(ERROR_NONE);
  for (std::uint32_t error = ERROR_NONE; error <= ERROR_OVERRUN; ++error) {
    if (fault.error == to_text(static_cast<LifecycleError>(error)))
      event.error(static_cast<LifecycleError>(error));
  }
  set(event.cause(), fault.cause);
  set(event.attachment(), fault.attachment);
  event.count(fault.count);
  event.cycle(fault.cycle);
  event.sequence_number(fault.sequence);
  event.time_ns(fault.time_ns);
  return event;
}

model::Fault from_wire(const FaultEvent& event) {
  return {.sequence = event.sequence_number(),
          .time_ns = event.time_ns(),
          .cell = event.cell().to_string(),
          .device = event.device().to_string(),
          .module = event.name().to_string(),
          .kind = static_cast<model::FaultKind>(event.kind()),
          .error = to_text(event.error()),
          .cause = event.cause().to_string(),
          .attachment = event.attachment().to_string(),
          .count = event.count(),
          .cycle = event.cycle()};
}

}  // namespace takt::wire
