// takt::EventPort: an InPort whose samples make a sporadic module ready to run.
#pragma once

#include <string>
#include <utility>

#include <takt/component/in_port.hpp>

namespace takt {

/// An event input. While it has an unread event, the default condition() of the module is true. run() may
/// read one event, or all: `while (alarm.read()) ...`. The thread rules of InPort apply.
template <class T>
class EventPort : public InPort<T> {
 public:
  /// The options of the input.
  using Options = PortOptions;

  /// Constructs an event input as a member of a component. It allocates memory, so real-time threads must not
  /// call it.
  EventPort(Component& owner, std::string name, Options options = {})
      : InPort<T>(&owner, std::move(name), PortDirection::event, std::move(options)) {}
  /// Constructs an event input of a program: a global variable, or a variable that is constructed before
  /// initPeriodExe() or initSporadicExe(). It allocates memory.
  explicit EventPort(std::string name, Options options = {})
      : InPort<T>(nullptr, std::move(name), PortDirection::event, std::move(options)) {}
};

}  // namespace takt
