// A periodic thread module for `takt bench cell`: writes the current time.
#include <chrono>

#include <takt/component.hpp>

#include <bench.hpp>

class BenchSender : public takt::Component {
  takt::OutPort<bench::Sample64> out{*this, "out", {.text = "The time at which the sample was written."}};

  bench::Sample64 sample_;

  void run(const takt::Cycle&) noexcept override {
    sample_.sent_ns(std::chrono::steady_clock::now().time_since_epoch().count());
    out.write(sample_);
  }
};
TAKT_COMPONENT(BenchSender)
