// A thread module in C++: the counters of IEC 61131-3.
#include <takt/component.hpp>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "iec_counter.hpp"

class UpDownCounter : public takt::Component {
  takt::InPort<basic::Flag> up{*this, "up", {.text = "CU: each rising edge counts up."}};
  takt::InPort<basic::Flag> down{*this, "down", {.text = "CD: each rising edge counts down."}};
  takt::InPort<basic::Flag> reset{*this, "reset", {.text = "R: while true, the value is 0."}};
  takt::InPort<basic::Flag> load{*this, "load", {.text = "LD: while true, the value is the preset."}};
  takt::OutPort<basic::Count> value{*this, "value", {.text = "CV: the value of the counter."}};
  takt::OutPort<basic::Flag> full{
      *this, "full", {.text = "QU (Q of CTU): the value is at least the preset."}};
  takt::OutPort<basic::Flag> empty{*this, "empty", {.text = "QD (Q of CTD): the value is at most 0."}};
  takt::Property<std::int64_t> preset{*this, "preset", 10, {.text = "PV: the preset value."}};

  struct Kept {
    up_down_counter::IecCounter counter;
    common::RisingEdge up, down;  // saved, so that an input that stays true does not count again
  };
  takt::Saved<Kept> kept_{*this, 1};
  basic::Count count_;
  basic::Flag flag_;

  void run(const takt::Cycle&) noexcept override {
    common::read_newest(reset);
    common::read_newest(load);
    up_down_counter::IecCounter& counter = kept_->counter;
    counter.step({.up = common::count_rising(up, kept_->up),
                  .down = common::count_rising(down, kept_->down),
                  .reset = reset.value().value(),
                  .load = load.value().value()},
                 preset);
    count_.value(counter.value());
    value.write(count_);
    flag_.value(counter.full(preset));
    full.write(flag_);
    flag_.value(counter.empty());
    empty.write(flag_);
  }
};
TAKT_COMPONENT(UpDownCounter, "Counts rising edges up and down: CTU, CTD and CTUD.")
