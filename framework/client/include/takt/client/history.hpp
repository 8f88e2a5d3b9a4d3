// Records the jitter and run time of each module of a domain in the last ten minutes, one entry per second.
//
// The statistics that a node publishes cover the time since the module was loaded. So after an hour, one bad
// second hardly changes them. From two successive statistics of a module, History computes the mean over the
// time between the two. It cannot compute quantiles over this time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <takt/wire/cell_state.hpp>

namespace takt::client {

/// The entries of one module, oldest first. All vectors have the same length. A second without statistics has
/// no entry.
struct Series {
  std::vector<std::int64_t> times_ms;  ///< time of each entry, in ms since 1970
  // The next four vectors cover the time since the module was loaded.
  std::vector<double> jitter_p50_us;
  std::vector<double> jitter_p99_us;
  std::vector<double> run_p50_us;
  std::vector<double> run_p99_us;
  // The next two vectors cover the time since the previous entry. A value is NaN if the module did not run or
  // if there is no previous entry.
  std::vector<double> jitter_us;  ///< root mean square of the jitter
  std::vector<double> run_us;     ///< mean of the run time
};

/// Holds the entries of all modules: at most kSeconds entries for each of at most kModules modules. Forgets a
/// module that has disappeared. Not thread-safe: only one thread at a time may call its functions. Uses
/// neither a clock nor the network.
class History {
 public:
  static constexpr std::size_t kSeconds = 600;
  static constexpr std::size_t kModules = 10000;

  /// Adds the latest statistics of the devices. Call this function several times a second. For each module,
  /// the function adds about one entry per second and ignores all other statistics.
  void add(const std::vector<wire::ObservedDevice>& devices);

  /// Returns the newest entries, at most `seconds`, of `module`, which is "DEVICE.MODULE". Empty if the
  /// module is unknown.
  [[nodiscard]] Series of(const std::string& module, std::size_t seconds = kSeconds) const;

 private:
  struct Entry {
    std::int64_t time_ms;
    float jitter_p50, jitter_p99, run_p50, run_p99, jitter, run;
  };
  struct Module {
    std::vector<Entry> entries;  // used as a ring buffer once it has kSeconds entries
    std::size_t next = 0;        // in a full ring: index of the oldest entry, which is overwritten next
    ModuleStatistics last;
    bool seen = false;
  };
  static void add(Module& module, const ModuleStatistics& now);

  std::map<std::string, Module> modules_;
};

}  // namespace takt::client
