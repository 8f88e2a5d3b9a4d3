// Records how each module of a domain behaved in the last ten minutes, one entry a second.
//
// A module's statistics of jitter and run time count from the moment it was loaded, so after an hour a bad
// second hardly shows. Two successive statistics give the mean over the time between them, but not the
// quantiles.
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
  // Over the time since the module was loaded.
  std::vector<double> jitter_p50_us;
  std::vector<double> jitter_p99_us;
  std::vector<double> run_p50_us;
  std::vector<double> run_p99_us;
  // Over the time since the previous entry. NaN: the module did not run, or there is no previous entry.
  std::vector<double> jitter_us;  ///< the root of the mean square
  std::vector<double> run_us;     ///< the mean
};

/// Uses neither clock nor network. One thread at a time. Memory is bounded: kSeconds entries for each of at
/// most kModules modules. A module that has disappeared is forgotten.
class History {
 public:
  static constexpr std::size_t kSeconds = 600;
  static constexpr std::size_t kModules = 10000;

  /// Call it several times a second with the present devices. It keeps one entry a second of each module and
  /// ignores statistics that it already has.
  void hear(const std::vector<wire::ObservedDevice>& devices);

  /// The newest `seconds` entries of `module`, "DEVICE.MODULE". Empty if there are none.
  [[nodiscard]] Series of(const std::string& module, std::size_t seconds = kSeconds) const;

 private:
  struct Entry {
    std::int64_t time_ms;
    float jitter_p50, jitter_p99, run_p50, run_p99, jitter, run;
  };
  struct Module {
    std::vector<Entry> entries;  // a ring once it is full
    std::size_t next = 0;        // where the ring is written next
    ModuleStatistics last;
    bool seen = false;
  };
  static void add(Module& module, const ModuleStatistics& now);

  std::map<std::string, Module> modules_;
};

}  // namespace takt::client
