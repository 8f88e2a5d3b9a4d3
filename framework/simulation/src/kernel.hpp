// A scheduler on virtual time. Each thread or process module of the simulated devices is a strand in this
// scheduler. A strand has its own CPU or shares a CPU by priority. It calls work() to use time, and waits for
// an instant or for a wake-up. Only one strand runs at a time, always the one with the earliest event. So the
// same strands with the same times always produce the same events, however fast the machine is.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <queue>
#include <vector>

#include <takt/core/clock.hpp>
#include <takt/core/time.hpp>
#include <takt/os/fiber.hpp>

namespace takt::simulation {

class Strand;

/// A simulated CPU. Among the strands that are ready, the strand with the highest priority runs. Among
/// strands of equal priority, it is the one that has been ready longest. A preempted strand does the rest of
/// its work later.
class Cpu {
 private:
  friend class Kernel;
  std::vector<Strand*> ready_;
  Strand* current_ = nullptr;
  Instant since_{};
  std::uint64_t turn_ = 0;  // number of changes on this CPU; an event of an earlier turn is outdated
};

class Strand {
 public:
  Strand(const Strand&) = delete;
  Strand& operator=(const Strand&) = delete;
  ~Strand() = default;
  [[nodiscard]] bool ended() const noexcept { return ended_; }
  /// A number above 0 that no other strand of the kernel has.
  [[nodiscard]] std::int32_t id() const noexcept { return id_; }

 private:
  friend class Kernel;
  Strand() = default;
  Cpu own_;
  Cpu* cpu_ = nullptr;
  int priority_ = 0;
  std::uint64_t ready_order_ = 0;  // position in the order in which strands became ready
  Nanoseconds left_{};             // the remaining work
  Nanoseconds ran_{};              // the CPU time used before the strand last got its CPU
  std::int32_t id_ = 0;
  std::uint64_t wait_ = 0;  // number of waits; an event of an earlier wait is outdated
  bool waits_ = false;
  bool woken_ = false;
  bool ended_ = false;
  std::unique_ptr<os::Fiber> fiber_;
};

/// Use this object from one thread only. Only the running strand may call work(), sleep_until(), wait() and
/// end().
class Kernel final : public Clock {
 public:
  explicit Kernel(Instant begin) : now_(begin) {}
  Kernel(const Kernel&) = delete;
  Kernel& operator=(const Kernel&) = delete;
  ~Kernel() override;

  [[nodiscard]] Instant now() noexcept override { return now_; }

  struct Scheduling {
    Cpu* cpu = nullptr;  ///< null: the strand has its own CPU
    int priority = 0;    ///< higher values run first
  };
  /// Makes a strand, which first runs at the present time. The strand may be killed whenever it waits or
  /// works, so at these points its stack must hold no objects whose destructors must run.
  Strand& spawn(const Scheduling& scheduling, std::function<void()> body);
  /// Ends another strand for ever. The running strand calls end() instead.
  void kill(Strand& strand);

  /// Makes the running strand use its CPU for `time`. Takes longer if strands of higher priority preempt the
  /// strand. Other events may happen during this time, unless `time` is 0.
  void work(Nanoseconds time);
  /// Makes the running strand release its CPU and sleep until `until`.
  void sleep_until(Instant until);
  /// Makes the running strand wait for a call of wake(). Returns false if `until` came first.
  bool wait(Instant until = Instant::max());
  /// Wakes a strand after `delay`. Does nothing if the strand is not waiting at that time.
  void wake(Strand& strand, Nanoseconds delay = Nanoseconds{0});
  /// Ends the running strand.
  [[noreturn]] void end();
  /// The strand that runs now; null if no strand runs.
  [[nodiscard]] Strand* running() const noexcept { return running_; }
  /// Returns the CPU time that a strand has used, if the strand has its CPU or is ready for it. Returns
  /// nothing if the strand waits or has ended, or if no strand has this id.
  [[nodiscard]] std::optional<Nanoseconds> ran_if_ready(std::int32_t id) const noexcept;

  /// Calls a function at the instant `when`, outside any strand. The call takes no simulated time.
  void at(Instant when, std::function<void()> call);

  /// Handles all events up to and including the instant `end`. A strand must not call this function.
  void run_until(Instant end);

 private:
  struct Event {
    Instant when;
    std::uint64_t order;  // decides between events at the same instant: the event that was caused first comes
                          // first
    Strand* strand;       // the strand that wakes up or has done its work; null if the event calls a function
    std::uint64_t valid;  // value of the strand's wait_ or its CPU's turn_ when the event was made; the event
                          // is outdated if the value has changed
    bool is_wake;
    std::size_t call;  // index in calls_
    bool operator>(const Event& other) const noexcept {
      return when != other.when ? when > other.when : order > other.order;
    }
  };
  static constexpr std::size_t kStackBytes = 128 * 1024;

  void push(Event event);
  void make_ready(Strand& strand, Nanoseconds work);
  void make_not_ready(Strand& strand);
  /// Takes the CPU from the strand that has it.
  void preempt(Cpu& cpu);
  void reschedule(Cpu& cpu);
  /// Finds the next event that is not outdated. Returns false if there is none up to end_.
  bool next(Event& event);
  void switch_to_next();
  void resume(Strand& strand);
  [[nodiscard]] bool is_outdated(const Event& event) const noexcept;

  Instant now_;
  Instant end_{};
  std::uint64_t order_ = 0;
  std::uint64_t ready_count_ = 0;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::vector<std::function<void()>> calls_;
  std::vector<std::size_t> free_calls_;
  std::vector<std::unique_ptr<Strand>> strands_;
  std::vector<Strand*> dead_;  // ended strands; the stack of one may still be in use
  Strand* running_ = nullptr;
  os::Fiber main_;
};

}  // namespace takt::simulation
