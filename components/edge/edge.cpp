// A thread module in C++: detects edges of a flag.
#include <takt/component.hpp>

#include <string>

#include <basic.hpp>

#include "edge_detector.hpp"

class Edge : public takt::Component {
  takt::InPort<basic::Flag> in{
      *this, "in", {.text = "The flag (CLK); connect it as a queue if the module must see every edge."}};
  takt::OutPort<basic::Flag> q{*this, "q", {.text = "True only in a cycle that sees an edge."}};
  takt::OutPort<basic::Count> count{*this, "count", {.text = "Number of edges since the start."}};
  takt::Property<std::string> direction{
      *this,
      "direction",
      "rising",
      {.text = "R_TRIG, F_TRIG, or both.", .choices = {"rising", "falling", "both"}}};
  takt::Property<bool> at_start{
      *this,
      "at_start",
      false,
      {.text = "True: the first sample can be an edge, as in IEC 61131-3 after a cold start."}};

  edge::EdgeDetector detector_;
  bool begun_ = false;
  basic::Flag q_;
  basic::Count count_;

  void run(const takt::Cycle&) noexcept override {
    detector_.rising = direction.value() != "falling";
    detector_.falling = direction.value() != "rising";
    std::int64_t edges = 0;
    while (in.read()) {
      const bool value = in.value().value();
      if (!begun_ && at_start) detector_.assume(!value);
      begun_ = true;
      edges += detector_.step(value) ? 1 : 0;
    }
    q_.value(edges > 0);
    q.write(q_);
    count_.value(count_.value() + edges);
    count.write(count_);
  }

  // During the error the module read no samples, so it does not know the last value of the flag.
  takt::Result<void> recover() override {
    detector_.forget();
    return {};
  }
};
TAKT_COMPONENT(Edge, "Detects rising and falling edges of a flag.")
