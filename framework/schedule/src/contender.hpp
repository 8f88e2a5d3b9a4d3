// A thread that competes for a processor, as those see it that must wait for it: how much processor time it
// may take away from them in any window of a given length.
//
// Two bounds. `fresh` counts what arrives in the window, and holds where nothing of the thread was waiting
// when the window began. `carried` also counts what had arrived before and was not done.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::schedule {

/// Sums of times that are any int64 need more than 64 bits.
__extension__ using Wide = __int128;
/// Longer than all that is looked at: 10^21 ns are more than 30,000 years.
inline constexpr Wide kForever = Wide{1'000'000'000'000} * 1'000'000'000;

/// The rows of an executor: known work on a known grid, in a circle.
class RowDemand {
 public:
  RowDemand() = default;
  /// `work` of each row of a macro period, at least one; before each release the thread spins for up to
  /// `spin`.
  RowDemand(std::vector<Wide> work, Nanoseconds basic_period, Nanoseconds spin);

  /// The most that rows which are released in a window of this length bring with them.
  [[nodiscard]] Wide in(Wide window) const;
  [[nodiscard]] Wide spin() const noexcept { return spin_; }

 private:
  [[nodiscard]] Wide most_of(std::size_t rows) const;

  std::vector<Wide> before_;  // the work of the rows before this one, over two macro periods
  Wide basic_ = 1;
  Wide spin_ = 0;
  mutable std::map<std::size_t, Wide> known_;
};

/// Something that is released again and again, never before it is done.
struct Recurring {
  Wide work = 0;      ///< of one release, with the spinning that goes with it
  Wide apart = 0;     ///< at least, between two releases; 0: nothing is known
  Wide jitter = 0;    ///< it may begin to ask for the processor this much later than it was released
  Wide response = 0;  ///< from its release until it is done or may be released again

  [[nodiscard]] Wide fresh(Wide window) const;
  [[nodiscard]] Wide carried(Wide window) const;
};

struct Contender {
  enum class Kind { rows, sporadic, program };

  Kind kind = Kind::rows;
  int priority = 0;
  std::vector<int> cpus{};        ///< on which it may run
  bool never_sleeps = false;      ///< it leaves nothing to what is not above it
  RowDemand rows{};               ///< of kind rows
  Wide rows_response = 0;         ///< no row ends later than this after its release
  std::vector<Recurring> jobs{};  ///< of the other kinds: each sporadic module, or the program
  /// Of a program: it sleeps after each body, and then waits for its turn behind its equals.
  bool sleeps_between = false;

  [[nodiscard]] bool may_run_on(int cpu) const;
  [[nodiscard]] bool stays() const noexcept { return cpus.size() == 1; }  ///< on one processor
  [[nodiscard]] Wide fresh(Wide window) const;
  [[nodiscard]] Wide carried(Wide window) const;
  /// What goes before one of the same priority that asks for a processor on which this one stays.
  [[nodiscard]] Wide before_equal(Wide window) const;
};

}  // namespace takt::schedule
