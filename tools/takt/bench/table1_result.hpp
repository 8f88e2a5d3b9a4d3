// The results of a run of Table 1, and a verdict that says whether they are within the limits.
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

/// The results of one case and of its bare loop. Half of the bare loop ran before the case, the other half
/// after the case.
struct CaseResult {
  Table1Case one;
  std::vector<Served> jitter;      ///< jitter of the measured module, Eq. (1)
  std::vector<std::int64_t> bare;  ///< jitter of the bare loop
  Distribution takt;               ///< statistics of `jitter`
  Distribution loop;               ///< statistics of `bare`
  std::uint64_t cycles = 0;        ///< rows that the executor ran
  std::uint64_t missed = 0;        ///< rows that the executor missed
  std::uint64_t loop_missed = 0;
  Nanoseconds stolen{};    ///< CPU time, on all CPUs, that other virtual machines took during the case
  bool real_time = false;  ///< Takt's threads ran with SCHED_FIFO
  bool loop_real_time = false;
};

struct Table1Result {
  os::Platform machine;
  std::int64_t wall_ns = 0;  ///< when the run began
  Nanoseconds period{};
  double seconds = 0;  ///< duration of each case, and of its bare loop
  int cpu = 0;         ///< the CPU of the executor and the bare loop
  int priority = 0;
  int cpus = 0;      ///< the number of CPUs that this program may use
  std::string load;  ///< the command line of the background load, or empty
  std::vector<CaseResult> cases;
};

/// Tells whether the results of a case are within the limits.
enum class Verdict {
  held,
  more_modules,  ///< the case exceeds the limits, and the machine has fewer CPUs than the case needs
  not_held,      ///< the case exceeds the limits, although the machine has enough CPUs
};
struct Judgement {
  Verdict verdict = Verdict::held;
  std::string why;  ///< the exceeded limits; empty if the verdict is `held`
};

/// Compares the results of a case with its limits. For a thread module, the p50 of the jitter must be at most
/// 0.1 us, and its p99 at most half of the bare loop's p99. If the period is 1 ms or longer, p99 must also be
/// at most 1 us. For a process module, the p50 must be at most 1 us.
Judgement judge(const CaseResult& result, Nanoseconds period, int cpus);

/// The text of a verdict: "held", "more modules than cores" or "not held".
const char* to_text(Verdict verdict);

/// The title of the table, which says what was measured.
std::string title_of(const Table1Result& result);

}  // namespace takt::bench
