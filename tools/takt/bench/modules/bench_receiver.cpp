// A sporadic thread module for `takt bench cell`: records the age of each sample. The writer is on the same
// machine, so it has the same clock.
#include <chrono>

#include <takt/component.hpp>

#include <bench.hpp>

#include "recording.hpp"

class BenchReceiver : public takt::Component {
  takt::EventPort<bench::Sample64> in{*this, "in", {.text = "The times that bench_sender.so wrote."}};
  takt::Property<std::string> file{
      *this,
      "file",
      "",
      {.text = "The file to which the module writes the ages at the end; if empty, it writes none."}};
  takt::Property<std::int64_t> samples{
      *this,
      "samples",
      0,
      {.min = 0, .max = 1'000'000'000, .text = "The maximum number of recorded samples."}};

  takt::bench::Recording ages_;
  std::int64_t count_ = 0;

  takt::Result<void> initialize() override {
    ages_.reserve(static_cast<std::size_t>(samples.value()));
    return {};
  }
  void run(const takt::Cycle&) noexcept override {
    while (in.read()) {
      const std::int64_t now = std::chrono::steady_clock::now().time_since_epoch().count();
      ages_.note(count_++, now - in.value().sent_ns());
    }
  }
  void destruct() override {
    if (!file.value().empty()) static_cast<void>(ages_.write(file));
  }
};
TAKT_COMPONENT(BenchReceiver)
