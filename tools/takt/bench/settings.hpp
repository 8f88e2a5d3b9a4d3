// The settings of all benchmarks.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include <takt/core/time.hpp>

namespace takt::bench {

/// The additional settings of `takt bench cell`.
struct CellSettings {
  int devices = 4;
  int pairs = 1;  ///< number of module pairs on each device: a sender to the next device, and a receiver from
                  ///< the previous one
};

struct Settings {
  std::optional<double> seconds;  ///< duration of each measurement; each benchmark has its own default
  std::optional<int>
      cpu;  ///< CPU of the real-time threads; by default the last one that this program may use
  std::optional<int> domain;          ///< DDS domain of nodes; by default the domain that `takt run` uses
  bool load = false;                  ///< run stress-ng during the measurements
  std::optional<Nanoseconds> period;  ///< period of the modules; each benchmark has its own default
  CellSettings cell{};
  /// If given, Course calls this before each measurement, with the progress so far and the name of the
  /// measurement.
  std::function<void(double share, const std::string& what)> progress{};

  [[nodiscard]] Nanoseconds length(double otherwise) const {
    return std::chrono::duration_cast<Nanoseconds>(
        std::chrono::duration<double>(seconds.value_or(otherwise)));
  }
};

/// Reports the progress of a benchmark before each measurement. Reports nothing during a measurement, because
/// drawing the progress would disturb the measurement.
class Course {
 public:
  /// `settings` must outlive this object. `measurements` is the number of measurements, which all take about
  /// the same time.
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

/// The CPU on which the real-time threads run.
int cpu_of(const Settings& settings);

}  // namespace takt::bench
