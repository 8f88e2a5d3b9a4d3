// A component for the tests of the test harness. The properties can select a fault of the component.
#include <takt/component.hpp>

#include <optional>
#include <stdexcept>

#include <basic.hpp>
#include <line.hpp>

class Subject : public takt::Component {
  takt::InPort<basic::Number> in{*this, "in"};
  takt::InPort<basic::Count> orders{*this, "orders"};
  takt::OutPort<basic::Number> out{*this, "out"};
  takt::OutPort<basic::Count> events{
      *this, "events", {.text = "One value per hook call, and the received orders."}};
  takt::InPort<line::BeltState> belt{*this, "belt"};
  takt::OutPort<line::BeltState> state{*this, "state"};
  takt::Property<double> gain{*this, "gain", 2, {.unit = "1", .min = 0, .max = 10}};
  takt::Property<std::string> how{*this, "how", "", {.text = "The fault: fail, throw, other, bound."}};
  takt::Property<std::int64_t> at{*this, "at", -1, {.text = "Cycle of the fault."}};
  takt::Property<bool> starts{*this, "starts", true};
  takt::Property<bool> recovers{*this, "recovers", true};

  std::optional<takt::OutPort<basic::Number>> late_port;
  std::optional<takt::Property<double>> late_property;

  void write_event(std::int64_t what) {
    basic::Count count;
    count.value(what);
    events.write(count);
  }

  takt::Result<void> initialize() override {
    if (how.value() == "late port") late_port.emplace(*this, "late");
    if (how.value() == "late property") late_property.emplace(*this, "late", 1);
    if (how.value() == "initialize") return takt::fail("no air pressure", "open the valve");
    write_event(-1);
    return {};
  }
  takt::Result<void> start() override {
    if (!starts) throw std::runtime_error("the drive is off");
    if (how.value() == "finish in start") finish();
    log().info("started with {}", how.value());
    write_event(-2);
    return {};
  }
  void run(const takt::Cycle& cycle) override {
    in.read();
    log().debug("gain is {}", gain.value());
    while (orders.read()) write_event(orders.value().value());
    if (static_cast<std::int64_t>(cycle.number) == at) {
      if (how.value() == "fail" || how.value() == "both") fail("the axis is blocked");
      if (how.value() == "finish" || how.value() == "both") finish();
      if (how.value() == "throw") throw std::runtime_error("division by zero");
      if (how.value() == "other") throw 1;
      if (how.value() == "bound") {
        line::BeltState none;
        none.mode(static_cast<line::BeltMode>(7));
        state.write(none);
      }
    }
    basic::Number result;
    result.value(how.value() == "number"   ? static_cast<double>(cycle.number)
                 : how.value() == "period" ? cycle.seconds()
                 : how.value() == "time"   ? static_cast<double>(takt::to_ns(cycle.time))
                 : how.value() == "age"    ? static_cast<double>(in.age().count())
                 : how.value() == "tied"   ? (in.connected() ? 1 : 0)
                                           : gain * in.value().value());
    out.write(result);
  }
  void error(takt::ErrorType type) override { write_event(-10 - static_cast<std::int64_t>(type)); }
  takt::Result<void> recover() override {
    if (!recovers) return takt::fail("still blocked");
    write_event(-3);
    return {};
  }
  void destruct() override { write_event(-4); }
};
TAKT_COMPONENT(Subject)
