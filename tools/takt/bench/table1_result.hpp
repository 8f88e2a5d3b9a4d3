// The results of a run of Table 1, and whether they are within the limits.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/os/platform.hpp>

#include "distribution.hpp"
#include "modules/recording.hpp"
#include "table1_cases.hpp"

namespace takt::bench {

/// One case, with the bare loop. Half of the bare loop ran before the case, half after it.
struct CaseResult {
  Table1Case one;
  std::vector<Served> jitter;      ///< of the measured module, Eq. (1)
  std::vector<std::int64_t> bare;  ///< of the bare loop
  Distribution takt;               ///< of `jitter`
  Distribution loop;               ///< of `bare`
  std::uint64_t cycles = 0;        ///< rows that the executor ran
  std::uint64_t missed = 0;        ///< rows that it missed
  std::uint64_t loop_missed = 0;
  Nanoseconds stolen{};    ///< CPU time, of all CPUs, that other virtual machines took during the case
  bool real_time = false;  ///< Takt's threads ran with SCHED_FIFO
  bool loop_real_time = false;
};

struct Table1Result {
  os::Platform machine;
  std::int64_t wall_ns = 0;  ///< begin of the run
  Nanoseconds period{};
  double seconds = 0;  ///< length of each case, and of its bare loop
  int cpu = 0;         ///< of the executor and the bare loop
  int priority = 0;
  int cpus = 0;      ///< that this program may use
  std::string load;  ///< the load started by the benchmark; empty: none
  std::vector<CaseResult> cases;
};

/// Whether a case is within the limits.
enum class Verdict {
  held,
  more_modules,  ///< not within the limits, and the machine has fewer CPUs than the case needs
  not_held,      ///< not within the limits, although the machine has enough CPUs
};
struct Judgement {
  Verdict verdict = Verdict::held;
  std::string why;  ///< which limits are exceeded; empty if held
};

/// Compares a case with its limits. For a thread module, p50 is at most 0.1 us, and p99 is at most half of
/// that of the bare loop; from a period of 1 ms on, p99 is also at most 1 us. For a process module, p50 is at
/// most 1 us.
Judgement judge(const CaseResult& result, Nanoseconds period, int cpus);

/// "held", "more modules than cores", "not held".
const char* to_text(Verdict verdict);

/// The title of the table: what was measured.
std::string title_of(const Table1Result& result);

}  // namespace takt::bench
