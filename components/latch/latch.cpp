// A thread module in C++: the bistable function blocks of IEC 61131-3.
#include <takt/component.hpp>

#include <string>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "bistable.hpp"

class Latch : public takt::Component {
  takt::InPort<basic::Flag> set{
      *this, "set", {.text = "Set: input S, or S1 of SR; false before the first sample."}};
  takt::InPort<basic::Flag> reset{
      *this, "reset", {.text = "Reset: input R, or R1 of RS; false before the first sample."}};
  takt::OutPort<basic::Flag> q{*this, "q", {.text = "Q1."}};
  takt::Property<std::string> kind{
      *this,
      "kind",
      "RS",
      {.text = "Which input wins if both are true; RS: reset, SR: set.", .choices = {"RS", "SR"}}};

  latch::Bistable bistable_;
  basic::Flag q_;

  void run(const takt::Cycle&) noexcept override {
    common::read_newest(set);
    common::read_newest(reset);
    q_.value(bistable_.step(set.value().value(), reset.value().value(), kind.value() == "SR"));
    q.write(q_);
  }

  takt::Result<void> recover() override {
    bistable_.reset();
    return {};
  }
};
TAKT_COMPONENT(Latch, "Holds a flag until a reset: SR and RS of IEC 61131-3.")
