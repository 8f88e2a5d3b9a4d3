// A thread module in C++: a value that follows another no faster than it may.
#include <takt/component.hpp>

#include <cmath>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "../common/periodic.hpp"
#include "../common/releases.hpp"
#include "slew_limiter.hpp"

class RateLimiter : public takt::Component {
  takt::InPort<basic::Number> in{*this, "in", {.text = "What is wanted."}};
  takt::InPort<basic::Flag> enable{*this, "enable", {.text = "False: the input goes through as it is."}};
  takt::OutPort<basic::Number> out{*this, "out", {.text = "What follows it, in its unit."}};
  takt::OutPort<basic::Flag> limiting{
      *this, "limiting", {.text = "The output is not yet where the input is."}};
  takt::Property<double> rate_up{
      *this, "rate_up", 1, {.unit = "1/s", .min = 0, .max = 1e12, .text = "How fast it may rise."}};
  takt::Property<double> rate_down{
      *this, "rate_down", 1, {.unit = "1/s", .min = 0, .max = 1e12, .text = "How fast it may fall."}};
  takt::Property<double> jerk{
      *this,
      "jerk",
      0,
      {.unit = "1/s^2", .min = 0, .max = 1e12, .text = "How fast the rate may change; 0: at once."}};

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

  // Goes on from its last value, at rest: a new start must not make it jump.
  takt::Result<void> recover() override {
    limiter_.jump(limiter_.value());
    releases_.reset();
    return {};
  }
};
TAKT_COMPONENT(RateLimiter, "Lets a value change no faster than allowed.")
