// Makes artificial recordings, with rows as an executor would write them.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <utility>

#include <takt/flight/recording.hpp>

namespace takt::flight {

/// An artificial recording of one executor `plc`, which has a basic period of 1 ms. The modules are m0, m1
/// and so on.
class Made {
 public:
  static constexpr std::int64_t kMs = 1'000'000;
  static constexpr std::int64_t kUs = 1'000;

  explicit Made(std::size_t modules = 3) {
    recording.cell = "cell";
    recording.device = "robot";
    recording.last = std::chrono::seconds{1000};
    for (std::size_t i = 0; i < modules; ++i) recording.modules.push_back({.name = "m" + std::to_string(i)});
    recording.executors.push_back(
        {.name = "plc", .basic_period = std::chrono::milliseconds{1}, .threads = {}});
  }

  /// Adds a row that is due at `release_ns` and begins `late_ns` later. The runs in the row follow each other
  /// without a gap. Returns the time at which the row ends.
  std::int64_t row(std::int64_t release_ns, std::int64_t late_ns,
                   std::initializer_list<std::pair<std::uint32_t, std::int64_t>> runs, bool ends = true) {
    std::int64_t now = release_ns + late_ns;
    add(channel::FlightKind::row, now, 0, late_ns);
    for (const auto& [module, took] : runs) {
      now += took;
      add(channel::FlightKind::run, now, module, took);
    }
    if (ends) add(channel::FlightKind::row_end, now, 0, 0);
    recording.taken_ns = now;
    return now;
  }
  /// Adds `count` punctual rows of 100 us, one per millisecond, from `first` ms on.
  void good(std::int64_t first, std::int64_t count) {
    for (std::int64_t i = first; i < first + count; ++i) row(i * kMs, 100, {{0, 40 * kUs}, {1, 60 * kUs}});
  }
  void add(channel::FlightKind kind, std::int64_t time_ns, std::uint32_t module, std::int64_t value) {
    auto& copy = recording.executors[0].threads[0].copy;
    copy.entries.push_back({time_ns, kind, module, static_cast<std::uint64_t>(value)});
    ++copy.written;
  }
  /// Adds a sample of the kernel's counters for the thread that runs the rows, on CPU 1. Returns the
  /// counters, so that a test can set them.
  os::ThreadUse& sample(std::int64_t time_ns, Nanoseconds stolen = {}) {
    Sample sample{.time_ns = time_ns, .threads = {}, .stolen = {Nanoseconds{0}, stolen}};
    sample.threads.push_back({os::ThreadUse{.cpu = 1}, std::nullopt});
    recording.samples.push_back(sample);
    return *recording.samples.back().threads[0][0];
  }

  Recording recording;
};

}  // namespace takt::flight
