// A thread module in C++: limits how fast a value changes.
#include <takt/component.hpp>

#include <cmath>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "../common/periodic.hpp"
#include "../common/releases.hpp"
#include "slew_limiter.hpp"

class RateLimiter : public takt::Component {
  takt::InPort<basic::Number> in{*this, "in", {.text = "Target value."}};
  takt::InPort<basic::Flag> enable{
      *this, "enable", {.text = "False: the input passes unchanged. Counts as true if not connected."}};
  takt::OutPort<basic::Number> out{*this, "out", {.text = "Limited value, in the unit of the input."}};
  takt::OutPort<basic::Flag> limiting{
      *this, "limiting", {.text = "True while the output differs from the input."}};
  takt::Property<double> rate_up{
      *this, "rate_up", 1, {.unit = "1/s", .min = 0, .max = 1e12, .text = "Maximum rate of a rise."}};
  takt::Property<double> rate_down{
      *this, "rate_down", 1, {.unit = "1/s", .min = 0, .max = 1e12, .text = "Maximum rate of a fall."}};
  takt::Property<double> jerk{
      *this,
      "jerk",
      0,
      {.unit = "1/s^2", .min = 0, .max = 1e12, .text = "Maximum change of the rate; 0: unlimited."}};

  rate_limiter::SlewLimiter limiter_;
  common::Releases releases_;
  bool begun_ = false;
  basic::Number output_;
  basic::Flag limiting_;

  takt::Result<void> initialize() override { return common::check_period(period()); }

  void run(const takt::Cycle& cycle) noexcept override {
    const std::uint64_t passed = releases_.step(cycle.number);
    common::read_newest(in);
    common::read_newest(enable);
    if (!in.has_value()) return;
    const double wanted = in.value().value();
    if (!std::isfinite(wanted)) {
      fail("the input is not a finite number");
      return;
    }
    if (!begun_ || (enable.has_value() && !enable.value().value())) {
      limiter_.jump(wanted);
      begun_ = true;
    } else {
      const rate_limiter::Limits limits{.up = rate_up, .down = rate_down, .jerk = jerk};
      for (std::uint64_t i = common::steps_for(passed); i > 0; --i)
        limiter_.step(wanted, limits, cycle.seconds());
    }
    output_.value(limiter_.value());
    out.write(output_);
    limiting_.value(limiter_.value() != wanted);
    limiting.write(limiting_);
  }

  // The output continues from its last value with rate 0, so that a recovery causes no jump.
  takt::Result<void> recover() override {
    limiter_.jump(limiter_.value());
    releases_.reset();
    return {};
  }
};
TAKT_COMPONENT(RateLimiter, "Limits how fast a value changes: its slew rate and its jerk.")
