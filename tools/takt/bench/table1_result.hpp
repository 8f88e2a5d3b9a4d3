// What a run of Table 1 has measured, and whether it is as it should be.
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

/// One case, with the bare loop of the same minute: half of it before, half after.
struct CaseResult {
  Table1Case one;
  std::vector<Served> jitter;      ///< of the measured module, Eq. (1)
  std::vector<std::int64_t> bare;  ///< of the bare loop
  Distribution takt;               ///< of `jitter`
  Distribution loop;               ///< of `bare`
  std::uint64_t cycles = 0;        ///< rows that the executor has walked
  std::uint64_t missed = 0;        ///< rows that it has not
  std::uint64_t loop_missed = 0;
  Nanoseconds stolen{};    ///< from all processors while the case ran, by other machines
  bool real_time = false;  ///< Takt's threads were SCHED_FIFO
  bool loop_real_time = false;
};

struct Table1Result {
  os::Platform machine;
  std::int64_t wall_ns = 0;  ///< when it began
  Nanoseconds period{};
  double seconds = 0;  ///< of each case, and of its bare loop
  int cpu = 0;         ///< of the executor and the bare loop
  int priority = 0;
  int processors = 0;  ///< that this program may use
  std::string load;    ///< what ran beside it; empty: nothing of ours
  std::vector<CaseResult> cases;
};

/// Whether a case is as it should be.
enum class Verdict {
  held,
  more_modules,  ///< it is not, and the machine has fewer processors than the case wants
  not_held,
};
struct Judgement {
  Verdict verdict = Verdict::held;
  std::string why;  ///< what is not as it should be; empty when held
};

/// A thread module: p50 at most 0.1 us, p99 at most half of the bare loop's and, from a period of 1 ms on, at
/// most 1 us. A process module: p50 at most 1 us.
Judgement judge(const CaseResult& result, Nanoseconds period, int processors);

/// "held", "more modules than cores", "not held".
const char* to_text(Verdict verdict);

/// What is measured, in words for above a table.
std::string title_of(const Table1Result& result);

}  // namespace takt::bench
