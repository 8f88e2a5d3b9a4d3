// The ten cases of Table 1 of the paper: how many modules of each kind run beside the measured one, and the
// results in the paper.
#pragma once

#include <array>
#include <string>

#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::bench {

struct Table1Case {
  int number = 0;
  // Periodic modules, including the measured one.
  int so = 0;
  int exe = 0;
  int sporadic_so = 0;
  int sporadic_exe = 0;
  int non_real = 0;
  model::ModuleType measured = model::ModuleType::thread;

  /// The values printed in the paper, in us (variance: us^2).
  struct Paper {
    double mean = 0;
    double variance = 0;
    double worst = 0;
  } paper{};

  /// The number of CPUs that the case needs: one for the executor and one for each real-time program.
  [[nodiscard]] int cpus_wanted() const noexcept { return 1 + exe + sporadic_exe; }
};

extern const std::array<Table1Case, 10> kTable1;
inline constexpr Nanoseconds kTable1Period = std::chrono::microseconds{100};

/// How a case is run on this machine.
struct Table1Settings {
  Nanoseconds period = kTable1Period;
  int cpu = 0;           ///< of the executor
  int priority = 80;     ///< of the executor
  std::string file;      ///< to which the measured module writes its recording
  std::size_t releases;  ///< maximum number of recorded releases
};

/// A descriptor of one device, "bench". The measured module, "measured", is the first of its row.
std::string descriptor_of(const Table1Case& one, const Table1Settings& settings);

}  // namespace takt::bench
