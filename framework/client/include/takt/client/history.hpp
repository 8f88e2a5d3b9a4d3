// Records how each module of a domain behaved in the last ten minutes, one entry a second.
//
// A module's statistics of jitter and run time cover the time since the module was loaded, so after an hour
// one bad second hardly shows. From two successive statistics, the mean over the time between them can be
// computed, but not the quantiles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <takt/wire/cell_state.hpp>

namespace takt::client {

/// Vectors of equal length, oldest entry first. A second without statistics has no entry.
struct Series {
  std::vector<std::int64_t> times_ms;  ///< since 1970
  // These cover the time since the module was loaded.
  std::vector<double> jitter_p50_us;
  std::vector<double> jitter_p99_us;
  std::vector<double> run_p50_us;
  std::vector<double> run_p99_us;
  // These cover the time since the previous entry. NaN if the module did not run or there is no previous
  // entry.
  std::vector<double> jitter_us;  ///< the root of the mean square
  std::vector<double> run_us;     ///< the mean
};

/// Uses neither clock nor network. One thread at a time may call it. It keeps at most kSeconds entries for
/// each of at most kModules modules, and forgets a module that has disappeared.
class History {
 public:
  static constexpr std::size_t kSeconds = 600;
  static constexpr std::size_t kModules = 10000;

  /// Adds the statistics of the present devices. Call it several times a second. It adds one entry a second
  /// for each module and ignores statistics that it already has.
  void hear(const std::vector<wire::ObservedDevice>& devices);

  /// Returns the newest `seconds` entries of `module`, which is "DEVICE.MODULE". Empty if there are none.
  [[nodiscard]] Series of(const std::string& module, std::size_t seconds = kSeconds) const;

 private:
  struct Entry {
    std::int64_t time_ms;
    float jitter_p50, jitter_p99, run_p50, run_p99, jitter, run;
  };
  struct Module {
    std::vector<Entry> entries;  // a ring buffer once it is full
    std::size_t next = 0;        // index of the next entry to write
    ModuleStatistics last;
    bool seen = false;
  };
  static void add(Module& module, const ModuleStatistics& now);

  std::map<std::string, Module> modules_;
};

}  // namespace takt::client
