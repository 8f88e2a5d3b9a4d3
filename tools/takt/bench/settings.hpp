// What every benchmark is asked for.
#pragma once

#include <optional>

#include <takt/core/time.hpp>

namespace takt::bench {

/// Of `takt bench cell`.
struct CellSettings {
  int devices = 4;
  int pairs =
      1;  ///< of modules on each: one that sends to the next device, one that hears from the one before
};

struct Settings {
  std::optional<double> seconds;      ///< of each measurement; none: the benchmark's own
  std::optional<int> cpu;             ///< of the real-time threads; none: the last one that may be used
  std::optional<int> domain;          ///< DDS, for those that start nodes; none: as `takt run` has it
  bool load = false;                  ///< stress-ng runs beside it
  std::optional<Nanoseconds> period;  ///< none: the benchmark's own
  CellSettings cell{};

  [[nodiscard]] Nanoseconds length(double otherwise) const {
    return std::chrono::duration_cast<Nanoseconds>(
        std::chrono::duration<double>(seconds.value_or(otherwise)));
  }
};

/// The processor of the real-time threads.
int cpu_of(const Settings& settings);

}  // namespace takt::bench
