// A case run for real: written as a descriptor, run by `takt run` in a node and a host of its own.
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
  std::vector<Served> jitter;  ///< of the measured module
  std::uint64_t cycles = 0;    ///< rows that were walked
  std::uint64_t missed = 0;    ///< rows that were not
  bool real_time = false;
  Nanoseconds stolen{};
};

Result<Measured> run_measured(const Table1Case& one, const RunSettings& settings, const ScratchFolder& folder,
                              Patience& patience);

/// Of each entry, its value.
std::vector<std::int64_t> values_of(const std::vector<Served>& served);

}  // namespace takt::bench
