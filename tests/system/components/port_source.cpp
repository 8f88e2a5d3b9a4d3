// Writes `burst` samples in each run, numbered from 1, after run() has waited for `delay` ms.
#include <takt/component.hpp>

#include <chrono>
#include <thread>

#include "sample.hpp"

class PortSource : public takt::Component {
  takt::OutPort<samples::Count> out{*this, "out", {.text = "Numbered from 1."}};
  takt::Property<std::int64_t> burst{*this, "burst", 1, {.min = 0}};

  takt::Property<std::int64_t> delay{*this, "delay", 0, {.min = 0, .text = "Time that run() waits, in ms."}};

  samples::Count count_;
  std::uint64_t number_ = 0;

  takt::Result<void> initialize() override {
    count_.few().reserve(4);
    return {};
  }
  void run(const takt::Cycle&) noexcept override {
    if (delay > 0) std::this_thread::sleep_for(std::chrono::milliseconds{delay});
    for (std::int64_t i = 0; i < burst; ++i) {
      fill(count_, ++number_);
      out.write(count_);
    }
  }
};
TAKT_COMPONENT(PortSource)
