// Runs a case of Table 1 in a real cell: writes a descriptor, which `takt run` then runs in its own node and
// host.
#pragma once

#include <optional>
#include <vector>

#include <takt/core/result.hpp>

#include "modules/recording.hpp"
#include "programs.hpp"
#include "scratch_folder.hpp"
#include "table1_cases.hpp"

namespace takt::bench {

struct RunSettings {
  Nanoseconds period{};
  int cpu = 0;
  int priority = 80;
  Nanoseconds length{};
  std::optional<int> domain;
};

struct Measured {
  std::vector<Served> jitter;  ///< the jitter of the measured module
  std::uint64_t cycles = 0;    ///< number of rows that ran
  std::uint64_t missed = 0;    ///< number of rows that were missed
  bool real_time = false;
  Nanoseconds stolen{};
};

Result<Measured> run_measured(const Table1Case& one, const RunSettings& settings, const ScratchFolder& folder,
                              Interruption& interruption);

/// The values of the recorded entries, without their numbers.
std::vector<std::int64_t> values_of(const std::vector<Served>& served);

}  // namespace takt::bench
