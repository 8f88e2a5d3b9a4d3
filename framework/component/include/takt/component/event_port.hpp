// Where events come in: an InPort whose samples make a sporadic module ready to run.
#pragma once

#include <string>
#include <utility>

#include <takt/component/in_port.hpp>

namespace takt {

/// While an event is there that was not read, the module's condition() holds, unless it has one of its own.
/// run() may read one event, or all: `while (alarm.read()) ...`.
template <class T>
class EventPort : public InPort<T> {
 public:
  using Options = PortOptions;

  EventPort(Component& owner, std::string name, Options options = {})
      : InPort<T>(&owner, std::move(name), PortDirection::event, std::move(options)) {}
  explicit EventPort(std::string name, Options options = {})
      : InPort<T>(nullptr, std::move(name), PortDirection::event, std::move(options)) {}
};

}  // namespace takt
