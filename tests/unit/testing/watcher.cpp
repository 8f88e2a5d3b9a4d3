// A sporadic component that publishes the sum of its events. The component runs when an event arrives, and
// also while its input `level` is above 10.
#include <takt/component.hpp>

#include <basic.hpp>

class Watcher : public takt::Component {
  takt::EventPort<basic::Number> alarm{*this, "alarm"};
  takt::InPort<basic::Number> level{*this, "level"};
  takt::OutPort<basic::Number> sum{*this, "sum"};
  takt::Property<bool> fails{*this, "fails", false, {.text = "True: condition() fails."}};
  basic::Number sum_;

  bool condition() override {
    if (fails) fail("the condition failed");
    level.read();
    return Component::condition() || level.value().value() > 10;
  }
  void run(const takt::Cycle&) noexcept override {
    while (alarm.read()) sum_.value(sum_.value() + alarm.value().value());
    sum.write(sum_);
  }
};
TAKT_COMPONENT(Watcher)
