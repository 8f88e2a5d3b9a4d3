// A scheduler on virtual time. Each thread or program of the simulated machines is a strand here. A strand
// has its own CPU or shares one by priority, calls work() to take time, and waits for an instant or for a
// wake-up. Only one strand runs at a time, always the one with the earliest event. So the same strands with
// the same times always produce the same events, however fast the machine is.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <queue>
#include <vector>

#include <takt/core/clock.hpp>
#include <takt/core/time.hpp>
#include <takt/os/fiber.hpp>

namespace takt::simulation {

class Strand;

/// A CPU. Of the strands that are ready, the one with the highest priority runs; among equals, the one that
/// has been ready longest. A preempted strand does the rest of its work later.
class Cpu {
 private:
  friend class Kernel;
  std::vector<Strand*> ready_;
  Strand* current_ = nullptr;
  Instant since_{};
  std::uint64_t turn_ = 0;  // counts changes of the CPU; an event of an earlier turn is outdated
};

class Strand {
 public:
  Strand(const Strand&) = delete;
  Strand& operator=(const Strand&) = delete;
  ~Strand() = default;
  [[nodiscard]] bool ended() const noexcept { return ended_; }

 private:
  friend class Kernel;
  Strand() = default;
  Cpu own_;
  Cpu* cpu_ = nullptr;
  int priority_ = 0;
  std::uint64_t ready_order_ = 0;  // position in the order in which strands became ready
  Nanoseconds left_{};             // the remaining work
  std::uint64_t wait_ = 0;         // counts waits; an event of an earlier wait is outdated
  bool waits_ = false;
  bool woken_ = false;
  bool ended_ = false;
  std::unique_ptr<os::Fiber> fiber_;
};

/// Must be used from one thread only. Only a strand may call the functions marked "strand"; any code may call
/// the others.
class Kernel final : public Clock {
 public:
  explicit Kernel(Instant begin) : now_(begin) {}
  Kernel(const Kernel&) = delete;
  Kernel& operator=(const Kernel&) = delete;
  ~Kernel() override;

  [[nodiscard]] Instant now() noexcept override { return now_; }

  struct Place {
    Cpu* cpu = nullptr;  ///< null for a CPU of its own
    int priority = 0;    ///< higher values run first
  };
  /// Makes a strand, which first runs at the present time. A strand may be killed whenever it waits or works,
  /// so its stack must then hold no objects that need their destructors.
  Strand& spawn(const Place& place, std::function<void()> body);
  /// Ends another strand for ever. The running strand calls end() instead.
  void kill(Strand& strand);

  /// Strand: uses its CPU for `time`. More time passes if strands of higher priority preempt it. Other events
  /// may happen meanwhile, unless `time` is 0.
  void work(Nanoseconds time);
  /// Strand: releases the CPU until `until`.
  void sleep_until(Instant until);
  /// Strand: waits for a wake(). Returns false if there was none before `until`.
  bool wait(Instant until = Instant::max());
  /// Wakes a strand after `delay`. Does nothing if the strand does not wait then.
  void wake(Strand& strand, Nanoseconds delay = Nanoseconds{0});
  /// Strand: ends itself.
  [[noreturn]] void end();
  /// Null if no strand runs.
  [[nodiscard]] Strand* running() const noexcept { return running_; }

  /// Calls a function at the instant `when`, outside any strand. The call takes no simulated time.
  void at(Instant when, std::function<void()> call);

  /// Not for strands: handles all events up to and including the instant `end`.
  void run_until(Instant end);

 private:
  struct Event {
    Instant when;
    std::uint64_t order;  // at the same instant, the event that was caused first comes first
    Strand* strand;       // the strand that wakes up or has done its work; null for a call of a function
    std::uint64_t valid;  // the strand's wait_, or the turn of its CPU
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
  void reschedule(Cpu& cpu);
  /// Finds the next event that is not outdated. Returns false if there is none until end_.
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
