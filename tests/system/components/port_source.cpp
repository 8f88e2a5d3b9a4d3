// Writes `burst` samples in each run, numbered from 1.
#include <takt/component.hpp>

#include "sample.hpp"

class PortSource : public takt::Component {
  takt::OutPort<samples::Count> out{*this, "out", {.text = "Numbered from 1."}};
  takt::Property<std::int64_t> burst{*this, "burst", 1, {.min = 0}};

  samples::Count count_;
  std::uint64_t number_ = 0;

  takt::Result<void> initialize() override {
    count_.few().reserve(4);
    return {};
  }
  void run(const takt::Cycle&) noexcept override {
    for (std::int64_t i = 0; i < burst; ++i) {
      fill(count_, ++number_);
      out.write(count_);
    }
  }
};
TAKT_COMPONENT(PortSource)
