// What every benchmark is asked for.
#pragma once

#include <functional>
#include <optional>
#include <string>

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
  /// Told how far it is and what is measured next; none: nobody waits for it. See Course.
  std::function<void(double share, const std::string& what)> progress{};

  [[nodiscard]] Nanoseconds length(double otherwise) const {
    return std::chrono::duration_cast<Nanoseconds>(
        std::chrono::duration<double>(seconds.value_or(otherwise)));
  }
};

/// The measurements of a benchmark, told one by one to whoever waits: before each and never in one, where
/// who draws would be measured too.
class Course {
 public:
  /// `settings` outlive it. `measurements`: of about the same length.
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

/// The processor of the real-time threads.
int cpu_of(const Settings& settings);

}  // namespace takt::bench
