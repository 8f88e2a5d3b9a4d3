// The ten cases of Table 1 of the paper. A case has the number of modules of each kind that run together with
// the measured module, and the results in the paper.
#pragma once

#include <array>
#include <string>

#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::bench {

struct Table1Case {
  int number = 0;
  // The numbers of modules of each kind. The periodic ones, `so` and `exe`, include the measured module.
  int so = 0;
  int exe = 0;
  int sporadic_so = 0;
  int sporadic_exe = 0;
  int non_real = 0;
  model::ModuleType measured = model::ModuleType::thread;

  /// The results in the paper, in us (the variance in us^2).
  struct Paper {
    double mean = 0;
    double variance = 0;
    double worst = 0;
  } paper{};

  /// The number of CPUs that the case needs: one for the executor and one for each real-time process module.
  [[nodiscard]] int cpus_wanted() const noexcept { return 1 + exe + sporadic_exe; }
};

extern const std::array<Table1Case, 10> kTable1;
inline constexpr Nanoseconds kTable1Period = std::chrono::microseconds{100};

/// The settings with which a case runs on this machine.
struct Table1Settings {
  Nanoseconds period = kTable1Period;
  int cpu = 0;           ///< the executor's CPU
  int priority = 80;     ///< the executor's priority
  std::string file;      ///< the file to which the measured module writes its recording
  std::size_t releases;  ///< the maximum number of recorded releases
};

/// The descriptor of a case, with one device, "bench". The measured module, "measured", is the first module
/// in its row.
std::string descriptor_of(const Table1Case& one, const Table1Settings& settings);

}  // namespace takt::bench
