// Virtual time. What would be threads and programs on several machines are strands here: each runs on a
// processor of its own or shares one by priority, takes time by saying so, and waits for instants or for
// others. One strand runs at a time, always the one whose turn comes first; so the same strands with the same
// times give the same course, however fast the machine is.
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

/// A processor: of the strands that want it the one with the highest priority has it, among equals the one
/// that has wanted it longest. Who is preempted goes on later with the work that is left.
class Processor {
 private:
  friend class Kernel;
  std::vector<Strand*> wanted_by_;
  Strand* has_ = nullptr;
  Instant since_{};
  std::uint64_t turn_ = 0;  // counts changes; an event of an earlier turn is void
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
  Processor own_;
  Processor* processor_ = nullptr;
  int priority_ = 0;
  std::uint64_t wants_since_ = 0;  // in the order of the wants
  Nanoseconds left_{};             // of the work
  std::uint64_t wait_ = 0;         // counts waits; an event of an earlier one is void
  bool waits_ = false;
  bool woken_ = false;
  bool ended_ = false;
  std::unique_ptr<os::Fiber> fiber_;
};

/// One thread. What is said of a strand below is for the code of a strand; the rest is for anybody.
class Kernel final : public Clock {
 public:
  explicit Kernel(Instant begin) : now_(begin) {}
  Kernel(const Kernel&) = delete;
  Kernel& operator=(const Kernel&) = delete;
  ~Kernel() override;

  [[nodiscard]] Instant now() noexcept override { return now_; }

  struct Place {
    Processor* processor = nullptr;  ///< null: one of its own
    int priority = 0;                ///< the larger goes first
  };
  /// Its first turn is at the present time. The body keeps nothing on its stack that must be destroyed
  /// whenever it waits or works: a strand may be killed there.
  Strand& spawn(const Place& place, std::function<void()> body);
  /// It never goes on. Not the strand that runs: that one calls end().
  void kill(Strand& strand);

  /// A strand: takes this much time of its processor, more on the clock where others of a higher priority
  /// come in between. Nothing else happens meanwhile only where it is 0.
  void work(Nanoseconds time);
  /// A strand: gives up the processor until then.
  void sleep_until(Instant until);
  /// A strand: until somebody wakes it. False: nobody did until then.
  bool wait(Instant until = Instant::max());
  /// A strand that waits is woken after `delay`; one that does not is not disturbed.
  void wake(Strand& strand, Nanoseconds delay = Nanoseconds{0});
  /// A strand: it never goes on.
  [[noreturn]] void end();
  /// Null when no strand runs.
  [[nodiscard]] Strand* running() const noexcept { return running_; }

  /// Calls somebody who is no strand; it takes no time.
  void at(Instant when, std::function<void()> call);

  /// Not a strand: lets everything happen until then, and up to and at that instant.
  void run_until(Instant end);

 private:
  struct Event {
    Instant when;
    std::uint64_t order;  // of two at one instant the one that was caused first
    Strand* strand;       // that is woken, or has done its work; null: a call
    std::uint64_t valid;  // the strand's wait_ or the turn of its processor
    bool is_wake;
    std::size_t call;  // index
    bool operator>(const Event& other) const noexcept {
      return when != other.when ? when > other.when : order > other.order;
    }
  };
  static constexpr std::size_t kStackBytes = 128 * 1024;

  void push(Event event);
  void want(Strand& strand, Nanoseconds work);
  void want_no_more(Strand& strand);
  void decide(Processor& processor);
  /// The next event that is not void; none before end_ or at all: false.
  bool next(Event& event);
  void pass_on();
  void go_to(Strand& strand);
  [[nodiscard]] bool is_void(const Event& event) const noexcept;

  Instant now_;
  Instant end_{};
  std::uint64_t order_ = 0;
  std::uint64_t wants_ = 0;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::vector<std::function<void()>> calls_;
  std::vector<std::size_t> free_calls_;
  std::vector<std::unique_ptr<Strand>> strands_;
  std::vector<Strand*> dead_;  // whose stack may be the one that is in use
  Strand* running_ = nullptr;
  os::Fiber main_;
};

}  // namespace takt::simulation
