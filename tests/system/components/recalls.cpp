// In start(), prints the value that its input port holds. If `number` is above 0, the module also writes this
// number to its output, exactly once.
#include <takt/component.hpp>

#include <cstdio>

#include "sample.hpp"

class Recalls : public takt::Component {
  takt::InPort<samples::Count> in{*this, "in"};
  takt::OutPort<samples::Count> out{*this, "out"};
  takt::Property<std::int64_t> number{*this, "number", 0};
  takt::Saved<bool> wrote_{*this, 1};
  samples::Count count_;

  takt::Result<void> initialize() override {
    count_.few().reserve(4);
    return {};
  }
  takt::Result<void> start() override {
    if (in.connected())
      std::printf("holds %llu\n", in.has_value() ? static_cast<unsigned long long>(in.value().number()) : 0);
    return {};
  }
  void run(const takt::Cycle&) noexcept override {
    in.read();
    if (number <= 0 || *wrote_) return;
    fill(count_, static_cast<std::uint64_t>(number.value()));
    out.write(count_);
    *wrote_ = true;
  }
};
TAKT_COMPONENT(Recalls)
