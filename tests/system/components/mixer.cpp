// Runs for a random time of up to `most` nanoseconds, then computes a number from its inputs and sends it.
// After `runs` runs, the number no longer changes. At the end, the module writes the number to `file`.
#include <takt/component.hpp>

#include <chrono>
#include <fstream>
#include <random>

#include "sample.hpp"

class Mixer : public takt::Component {
  takt::InPort<samples::Count> a{*this, "a"};
  takt::InPort<samples::Count> b{*this, "b"};
  takt::OutPort<samples::Count> out{*this, "out"};
  takt::Property<std::int64_t> runs{*this, "runs", 50, {.min = 1}};
  takt::Property<std::int64_t> most{*this, "most", 1, {.unit = "ns", .min = 1}};
  takt::Property<std::string> file{*this, "file", ""};

  samples::Count count_;
  std::uint64_t state_ = 1;
  std::int64_t done_ = 0;
  std::minstd_rand random_{std::random_device{}()};

  void mix(std::uint64_t number) { state_ = (state_ ^ number) * 0x9e3779b97f4a7c15U + 1; }
  void mix(takt::InPort<samples::Count>& in) {
    while (in.read()) {
      mix(in.value().number());
      mix(in.sequence());
      mix(static_cast<std::uint64_t>(in.age().count()));
    }
    mix(in.has_value() ? in.value().number() : 0);
  }
  void wait() {
    const auto part = static_cast<std::int64_t>(random_()) % most.value();
    const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds{part};
    while (std::chrono::steady_clock::now() < end) {
    }
  }

  takt::Result<void> initialize() override {
    count_.few().reserve(4);
    return {};
  }
  void run(const takt::Cycle& cycle) noexcept override {
    if (done_ == runs) return;
    wait();
    mix(a);
    mix(b);
    mix(cycle.number);
    wait();
    fill(count_, state_ % 1'000'000 + 1);
    out.write(count_);
    ++done_;
  }
  void destruct() override {
    if (!file.value().empty()) std::ofstream(file.value()) << done_ << ' ' << state_ << '\n';
  }
};
TAKT_COMPONENT(Mixer)
