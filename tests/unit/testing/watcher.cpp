// A sporadic component: tells the sum of its events, and, when it is to have a mind of its own, only of large
// ones.
#include <takt/component.hpp>

#include <basic.hpp>

class Watcher : public takt::Component {
  takt::EventPort<basic::Number> alarm{*this, "alarm"};
  takt::InPort<basic::Number> level{*this, "level"};
  takt::OutPort<basic::Number> sum{*this, "sum"};
  takt::Property<bool> fails{*this, "fails", false, {.text = "condition() does."}};
  basic::Number sum_;

  bool condition() override {
    if (fails) fail("no idea");
    level.read();
    return Component::condition() || level.value().value() > 10;
  }
  void run(const takt::Cycle&) noexcept override {
    while (alarm.read()) sum_.value(sum_.value() + alarm.value().value());
    sum.write(sum_);
  }
};
TAKT_COMPONENT(Watcher)
