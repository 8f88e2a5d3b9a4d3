// A thread that competes for a CPU. Computes upper bounds of the CPU time that the thread may take from other
// threads in any time window of a given length.
//
// There are two bounds. `fresh` counts only the work that arrives within the window. It is valid if no work
// of the thread was waiting when the window began. `carried` also counts unfinished work that arrived before
// the window.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::schedule {

/// A 128-bit integer, because sums of int64 times need more than 64 bits.
__extension__ using Wide = __int128;
/// Means that there is no bound: 10^21 ns are more than 30,000 years.
inline constexpr Wide kForever = Wide{1'000'000'000'000} * 1'000'000'000;

/// The CPU time that the rows of an executor need. The rows are released on a known grid, and their work
/// repeats with each macro period.
class RowDemand {
 public:
  RowDemand() = default;
  /// `work` contains the work of each row of a macro period; there is at least one row. The thread spins for
  /// up to `spin` before each release.
  RowDemand(std::vector<Wide> work, Nanoseconds basic_period, Nanoseconds spin);

  /// The maximum work of all rows that are released in a window of this length, including spinning.
  [[nodiscard]] Wide in(Wide window) const;
  [[nodiscard]] Wide spin() const noexcept { return spin_; }

 private:
  [[nodiscard]] Wide most_of(std::size_t rows) const;

  std::vector<Wide> before_;  // for each row of two macro periods, the total work of all rows before it
  Wide basic_ = 1;
  Wide spin_ = 0;
  mutable std::map<std::size_t, Wide> known_;
};

/// A job that is released repeatedly, but never before its previous run has ended. Times are in ns.
struct Recurring {
  Wide work = 0;      ///< work of one release, including its spinning
  Wide apart = 0;     ///< minimum time between two releases; 0 if not known
  Wide jitter = 0;    ///< maximum time from a release until the job requests the CPU
  Wide response = 0;  ///< time from a release until the job has ended or may be released again

  [[nodiscard]] Wide fresh(Wide window) const;
  [[nodiscard]] Wide carried(Wide window) const;
};

/// A thread that competes for CPUs.
struct Contender {
  enum class Kind { rows, sporadic, program };

  Kind kind = Kind::rows;
  int priority = 0;
  std::vector<int> cpus{};        ///< the CPUs on which the thread may run
  bool never_sleeps = false;      ///< true if the thread leaves no CPU time to threads of equal or lower
                                  ///< priority
  RowDemand rows{};               ///< for Kind::rows
  Wide rows_response = 0;         ///< for Kind::rows: the latest end of a row, counted from the row's release
  std::vector<Recurring> jobs{};  ///< for the other kinds: one job for each sporadic thread module, or the
                                  ///< job of the process module

  [[nodiscard]] bool may_run_on(int cpu) const;
  /// Returns true if the thread has only one CPU.
  [[nodiscard]] bool stays() const noexcept { return cpus.size() == 1; }
  [[nodiscard]] Wide fresh(Wide window) const;
  [[nodiscard]] Wide carried(Wide window) const;
};

}  // namespace takt::schedule
