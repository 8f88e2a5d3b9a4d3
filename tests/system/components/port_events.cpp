// A sporadic module that runs each time an event arrives, and reads one event in each run. It writes a
// summary to `file` at the end.
#include <takt/component.hpp>

#include <string>

#include "seen_file.hpp"

class PortEvents : public takt::Component {
  takt::EventPort<samples::Count> event{*this, "event"};
  takt::OutPort<samples::Count> echo{*this, "echo"};
  takt::Property<std::string> file{*this, "file", ""};

  Seen seen_;

  void run(const takt::Cycle&) noexcept override {
    if (!event.read()) fail("called without an event");
    seen_.take(event.value(), event.age().count());
    echo.write(event.value());
  }
  void destruct() override { write_seen(file, seen_); }
};
TAKT_COMPONENT(PortEvents)
