// A thread that competes for a CPU: bounds the CPU time that it may take from other threads in any window of
// a given length.
//
// There are two bounds. `fresh` counts only the work that arrives in the window. It is valid if none of the
// thread's work was waiting when the window began. `carried` also counts unfinished work that arrived before.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::schedule {

/// Sums of int64 times need more than 64 bits.
__extension__ using Wide = __int128;
/// Stands for "no bound": 10^21 ns are more than 30,000 years.
inline constexpr Wide kForever = Wide{1'000'000'000'000} * 1'000'000'000;

/// The rows of an executor: known work on a known grid that repeats.
class RowDemand {
 public:
  RowDemand() = default;
  /// `work` is the work of each row of a macro period, at least one row. The thread spins for up to `spin`
  /// before each release.
  RowDemand(std::vector<Wide> work, Nanoseconds basic_period, Nanoseconds spin);

  /// The maximum work of the rows released in a window of this length, including the spinning.
  [[nodiscard]] Wide in(Wide window) const;
  [[nodiscard]] Wide spin() const noexcept { return spin_; }

 private:
  [[nodiscard]] Wide most_of(std::size_t rows) const;

  std::vector<Wide> before_;  // the total work of all rows before each row, over two macro periods
  Wide basic_ = 1;
  Wide spin_ = 0;
  mutable std::map<std::size_t, Wide> known_;
};

/// A job that is released repeatedly, but never before its previous run is done. Times in ns.
struct Recurring {
  Wide work = 0;      ///< of one release, including its spinning
  Wide apart = 0;     ///< minimum time between two releases; 0: not known
  Wide jitter = 0;    ///< maximum time from its release until it requests the CPU
  Wide response = 0;  ///< from its release until it is done or may be released again

  [[nodiscard]] Wide fresh(Wide window) const;
  [[nodiscard]] Wide carried(Wide window) const;
};

/// A thread that competes for CPUs.
struct Contender {
  enum class Kind { rows, sporadic, program };

  Kind kind = Kind::rows;
  int priority = 0;
  std::vector<int> cpus{};        ///< the CPUs on which it may run
  bool never_sleeps = false;      ///< it leaves no time to threads of equal or lower priority
  RowDemand rows{};               ///< for kind rows
  Wide rows_response = 0;         ///< the latest end of a row after its release
  std::vector<Recurring> jobs{};  ///< for the other kinds: each sporadic module, or the program
  /// For a program: it sleeps after each run of its body, and then waits behind threads of equal priority.
  bool sleeps_between = false;

  [[nodiscard]] bool may_run_on(int cpu) const;
  [[nodiscard]] bool stays() const noexcept { return cpus.size() == 1; }  ///< whether it has only one CPU
  [[nodiscard]] Wide fresh(Wide window) const;
  [[nodiscard]] Wide carried(Wide window) const;
  /// The work that goes before a thread of equal priority on the CPU on which this thread stays.
  [[nodiscard]] Wide before_equal(Wide window) const;
};

}  // namespace takt::schedule
