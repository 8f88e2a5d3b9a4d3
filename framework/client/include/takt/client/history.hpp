// How the modules of a domain were lately, once a second.
//
// What a module says of its jitter and run time counts since it was loaded, so after an hour a bad second
// hardly shows. Of two statistics that follow each other, what lay between them can be told: not its
// quantiles, but its means.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <takt/dds/cell_state.hpp>

namespace takt::client {

/// Equally long, the oldest first, times ascending. A second in which nothing was heard is left out.
struct Series {
  std::vector<std::int64_t> times_ms;  ///< since 1970
  // Since the module was loaded.
  std::vector<double> jitter_p50_us;
  std::vector<double> jitter_p99_us;
  std::vector<double> run_p50_us;
  std::vector<double> run_p99_us;
  // Since the entry before. NaN: the module did not run meanwhile, or there was no entry before.
  std::vector<double> jitter_us;  ///< the root of the mean square
  std::vector<double> run_us;     ///< the mean
};

/// Pure, one thread at a time. Memory is bounded: kSeconds of at most kModules, who is not seen any more is
/// forgotten.
class History {
 public:
  static constexpr std::size_t kSeconds = 600;
  static constexpr std::size_t kModules = 10000;

  /// To be told again whenever, but several times a second; what was heard before is passed over. One of two
  /// entries of the same second is.
  void hear(const std::vector<dds::ObservedDevice>& devices);

  /// "DEVICE.MODULE"; empty where nothing was heard of it. The newest `seconds` entries.
  [[nodiscard]] Series of(const std::string& module, std::size_t seconds = kSeconds) const;

 private:
  struct Entry {
    std::int64_t time_ms;
    float jitter_p50, jitter_p99, run_p50, run_p99, jitter, run;
  };
  struct Module {
    std::vector<Entry> entries;  // a ring as soon as it is full
    std::size_t next = 0;        // where the ring is written
    ModuleStatistics last;
    bool seen = false;
  };
  static void add(Module& module, const ModuleStatistics& now);

  std::map<std::string, Module> modules_;
};

}  // namespace takt::client
