// The settings of all benchmarks.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include <takt/core/time.hpp>

namespace takt::bench {

/// Settings of `takt bench cell`.
struct CellSettings {
  int devices = 4;
  int pairs =
      1;  ///< pairs of modules on each device: one sends to the next device, one receives from the previous
};

struct Settings {
  std::optional<double> seconds;  ///< length of each measurement; none: the benchmark's default
  std::optional<int> cpu;         ///< of the real-time threads; none: the last CPU that this program may use
  std::optional<int> domain;      ///< DDS domain of benchmarks that start nodes; none: as for `takt run`
  bool load = false;              ///< run stress-ng at the same time
  std::optional<Nanoseconds> period;  ///< none: the benchmark's default
  CellSettings cell{};
  /// Called with the progress and the name of the next measurement; none: no progress is shown. See Course.
  std::function<void(double share, const std::string& what)> progress{};

  [[nodiscard]] Nanoseconds length(double otherwise) const {
    return std::chrono::duration_cast<Nanoseconds>(
        std::chrono::duration<double>(seconds.value_or(otherwise)));
  }
};

/// Reports the progress of a benchmark: before each measurement, never during one, because drawing the
/// progress would disturb it.
class Course {
 public:
  /// `settings` outlive this object. `measurements` is the number of measurements, which all have about the
  /// same length.
  Course(const Settings& settings, int measurements)
      : progress_(settings.progress), measurements_(measurements) {}

  void next(const std::string& what) {
    if (progress_) progress_(static_cast<double>(done_) / measurements_, what);
    ++done_;
  }

 private:
  const std::function<void(double share, const std::string& what)>& progress_;
  int measurements_;
  int done_ = 0;
};

/// The CPU of the real-time threads.
int cpu_of(const Settings& settings);

}  // namespace takt::bench
