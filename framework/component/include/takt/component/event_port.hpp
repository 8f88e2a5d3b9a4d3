// takt::EventPort: an InPort whose samples make a sporadic module ready to run.
#pragma once

#include <string>
#include <utility>

#include <takt/component/in_port.hpp>

namespace takt {

/// An event input. While the port has an unread event, the default condition() of the module is true. run()
/// may read one event, or all events: `while (alarm.read()) ...`. The thread rules of InPort apply.
template <class T>
class EventPort : public InPort<T> {
 public:
  /// The options of the input.
  using Options = PortOptions;

  /// Constructs an event input as a member of a component. Allocates memory, so not for real-time threads.
  EventPort(detail::Owner owner, std::string name, Options options = {})
      : InPort<T>(owner.component(), std::move(name), PortDirection::event, std::move(options)) {}
  /// Constructs an event input in a process module. The event input must be a global variable, or must be
  /// constructed before initPeriodExe() or initSporadicExe() is called. Allocates memory.
  explicit EventPort(std::string name, Options options = {})
      : InPort<T>(nullptr, std::move(name), PortDirection::event, std::move(options)) {
    static_assert(detail::InProgram<T>,
                  "pass *this as the first argument: takt::EventPort<T> in{*this, \"in\"}; only a program, "
                  "which includes <takt/process.hpp>, omits it");
  }
};

}  // namespace takt
