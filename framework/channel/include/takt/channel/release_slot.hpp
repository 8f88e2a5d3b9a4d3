// How a process module is released. Each has a slot: shared memory of its own, so that a program that writes
// where it should not harms no other. The scheduler releases it with one store; the program answers with
// another when its body is done.
//
// A program that finds no release where it expects one sleeps on the wake_word, a word that all programs of
// the device share, each with a bit of its own: so the scheduler needs one wake-up call a cycle, however many
// sleep.
//
// A sporadic program that is dispatched at once is released by nobody but itself, when its event ports have
// news: it does to its own slot what the scheduler does to another's. So "released and not done" means "in
// its body" whoever released it, and no row ever meets it half way.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include <takt/channel/layout.hpp>
#include <takt/channel/saved_state.hpp>
#include <takt/core/statistics.hpp>

namespace takt::channel {

struct WakeWord {
  std::atomic<std::uint32_t> rings;
  /// Bits that are to be rung once the cycle is over, because a sample was written for somebody who waits.
  /// Whoever wrote takes them with take_pending() at the end of its cycle and rings. SYNC: pending
  std::atomic<std::uint32_t> pending;
  /// Gateways that sleep, or are about to, a bit each (one for each domain of DDS): the only case in which a
  /// sample for them needs a ring. SYNC: gateway sleeps
  std::atomic<std::uint32_t> gateway_sleeps;

  /// Real-time. To be called after a sample was published on a link with these wake bits.
  void note(std::uint32_t wake_bits) noexcept;
  /// Real-time. The bits that are pending; none are afterwards. Costs a load where there are none.
  std::uint32_t take_pending() noexcept {
    return pending.load(std::memory_order_seq_cst) == 0 ? 0 : pending.exchange(0, std::memory_order_seq_cst);
  }
};

/// The wake_word's bits: one for the threads of sporadic modules, one for the gateways, one for the threads
/// that handle requests, the others for programs in turn.
inline constexpr std::uint32_t kSporadicBit = 1U << 31;
inline constexpr std::uint32_t kGatewayBit = 1U << 30;
inline constexpr std::uint32_t kServiceBit = 1U << 29;
constexpr std::uint32_t bell_bit(std::size_t slot) { return 1U << (slot % 29); }

inline void WakeWord::note(std::uint32_t wake_bits) noexcept {
  if ((wake_bits & kGatewayBit) != 0 && gateway_sleeps.load(std::memory_order_seq_cst) == 0)
    wake_bits &= ~kGatewayBit;
  if (wake_bits != 0) pending.fetch_or(wake_bits, std::memory_order_seq_cst);
}

/// More than any program is ever pending.
inline constexpr std::uint32_t kMaxOwed = 1U << 16;

enum class ReleaseSlotKind : std::uint32_t { periodic, sporadic, unscheduled };
enum class ReleaseSlotPhase : std::uint32_t {
  empty,     ///< no program, or it has not called initPeriodExe() or initSporadicExe() yet
  attached,  ///< it has
  ready,     ///< it has come to its first waitPeriod() or waitSporadic()
};

struct alignas(64) ReleaseSlot {
  static constexpr std::uint64_t kMagic = 0x7365'6174'0000'0006;  // "slot", layout 6

  // Written by the node before the program starts.
  std::uint64_t magic;
  Name name;
  ReleaseSlotKind kind;
  std::uint32_t bell_bit;
  std::int64_t period_ns;      ///< between releases
  std::int64_t offset_ns;      ///< of the first one from T0
  std::int64_t margin_cap_ns;  ///< the longest time before a release that the program may spin
  std::uint32_t lock_memory;
  std::int64_t deadline_ns;      ///< of a sporadic program, from its release to its next wait; 0: none
  std::uint32_t immediate;       ///< it releases itself: begin(); the scheduler never does
  std::int64_t interarrival_ns;  ///< of one that does: the least time between two releases
  std::uint32_t logical;         ///< inputs as of the release, outputs at the end of the period
  std::uint32_t catch_up;        ///< releases that it may be given in its body, served after it; 0: none

  // Written by the scheduler; of a program that releases itself, by the program.
  alignas(
      64) std::atomic<std::uint32_t> released;  ///< releases so far. SYNC: released, publishes the two below
  /// The number of the last release lies at its count modulo 2, so that the next one does not disturb who
  /// reads it.
  std::array<std::atomic<std::uint64_t>, 2> cycles;
  std::atomic<std::int64_t> release_ns;  ///< of the last one
  std::atomic<std::uint32_t> end;        ///< by the node: the program is to end
  std::atomic<std::uint32_t> open;       ///< by the node: the module is in the tables, it may release itself.
                                         ///< SYNC: open
  std::atomic<std::int64_t> t0_ns;       ///< by the node: T0 of the rows

  // Written by the program.
  alignas(64) std::atomic<std::uint32_t> done;  ///< the last release that it has finished. SYNC: done
  std::atomic<std::uint32_t> sleeping;  ///< it sleeps on the wake_word, or is about to. SYNC: sleeping
  std::atomic<ReleaseSlotPhase> phase;
  std::atomic<std::int32_t> thread;
  std::atomic<std::int64_t> body_began_ns;  ///< the last body that has ended, before `done` says so
  std::atomic<std::int64_t> body_ended_ns;
  std::atomic<std::int64_t> margin_ns;
  std::atomic<std::uint64_t>
      late;  ///< bodies that ended after the deadline. SYNC: late, publishes late_by_ns
  std::atomic<std::int64_t> late_by_ns;  ///< how long after, the last of them
  std::atomic<std::uint64_t> begun;      ///< bodies for which it released itself
  Statistics jitter;                     ///< Eq. (1), P_n - T_n, with T_n taken by the program
  Statistics run;
  SavedState saved;  ///< after each body; by the node while there is no program

  /// It was released and is not done.
  [[nodiscard]] bool in_body() const noexcept {
    return done.load(std::memory_order_acquire) != released.load(std::memory_order_seq_cst);
  }
  /// The number of the release with this count, the last one.
  [[nodiscard]] std::uint64_t cycle(std::uint32_t count) const noexcept {
    return cycles[count % 2].load(std::memory_order_acquire);
  }
  [[nodiscard]] bool waiting() const noexcept {
    return phase.load(std::memory_order_acquire) == ReleaseSlotPhase::ready && !in_body();
  }
};

enum class Release {
  given,    ///< the program is awake and sees it
  wake,     ///< the program sleeps: ring the wake_word for its bit
  pending,  ///< it is still in its body, and served this release after it
  busy,  ///< it is still in its body; a release is left out: this one, or, of one that catches up, the oldest
         ///< that it is pending
};

/// By the scheduler. Real-time: no lock, no system call.
inline Release release(ReleaseSlot& slot, std::uint64_t cycle, std::int64_t release_ns) noexcept {
  const std::uint32_t count = slot.released.load(std::memory_order_relaxed) + 1;
  if (!slot.waiting()) {
    if (slot.catch_up == 0 || slot.phase.load(std::memory_order_acquire) != ReleaseSlotPhase::ready)
      return Release::busy;
    const std::uint32_t pending = count - 2 - slot.done.load(std::memory_order_acquire);
    // Done meanwhile: then it is one of the last, and what was said of it holds.
    if (pending >= slot.catch_up && pending < kMaxOwed) {
      slot.cycles[(count - 1) % 2].store(cycle, std::memory_order_relaxed);
      return Release::busy;
    }
    slot.cycles[count % 2].store(cycle, std::memory_order_relaxed);
    slot.release_ns.store(release_ns, std::memory_order_relaxed);
    slot.released.store(count, std::memory_order_seq_cst);
    return slot.sleeping.load(std::memory_order_seq_cst) != 0 ? Release::wake : Release::pending;
  }
  slot.cycles[count % 2].store(cycle, std::memory_order_relaxed);
  slot.release_ns.store(release_ns, std::memory_order_relaxed);
  // SYNC: released and sleeping. Each side stores its own word and then loads the other's, in one total
  // order: either the scheduler sees that the program sleeps, or the program sees the release before it
  // sleeps.
  slot.released.store(count, std::memory_order_seq_cst);
  return slot.sleeping.load(std::memory_order_seq_cst) != 0 ? Release::wake : Release::given;
}

/// A release as its program takes it.
struct Taken {
  std::uint32_t count = 0;
  std::uint64_t cycle = 0;
  std::int64_t release_ns = 0;
};

/// By the program, when there is one after `done`: the next. Releases that it was given while it was in its
/// body come one by one, the oldest first; their numbers are the last ones. Real-time.
inline Taken take(const ReleaseSlot& slot, std::uint32_t done) noexcept {
  while (true) {
    const std::uint32_t count = slot.released.load(std::memory_order_acquire);  // SYNC: released
    const std::uint64_t newest = slot.cycle(count);
    const std::int64_t release_ns = slot.release_ns.load(std::memory_order_acquire);
    const std::uint64_t later = count - done - 1;                          // than the one that is taken
    if (slot.released.load(std::memory_order_relaxed) != count) continue;  // another has come: look again
    if (slot.catch_up == 0) return {count, newest, release_ns};
    const std::uint64_t cycle = newest - later;
    return {done + 1, cycle,
            slot.t0_ns.load(std::memory_order_relaxed) + slot.offset_ns +
                static_cast<std::int64_t>(cycle) * slot.period_ns};
  }
}

/// By a program that is dispatched at once, when it has news and its interarrival time has passed: the
/// release that it gives itself at `now_ns`. False when the module is not in the tables; then there was none.
/// Real-time.
inline bool begin(ReleaseSlot& slot, std::int64_t now_ns) noexcept {
  constexpr auto relaxed = std::memory_order_relaxed;
  if (slot.open.load(relaxed) == 0) return false;
  // As in a row: the number of the one that comes next.
  const std::int64_t since_t0 = now_ns - slot.t0_ns.load(relaxed);
  const bool rows = slot.period_ns > 0 && since_t0 > 0;
  const std::int64_t row = rows ? (since_t0 + slot.period_ns - 1) / slot.period_ns : 0;
  const std::uint32_t mine = slot.released.load(relaxed) + 1;
  slot.cycles[mine % 2].store(static_cast<std::uint64_t>(row), relaxed);
  slot.release_ns.store(now_ns, relaxed);
  // SYNC: open. The program says that it is in its body and then looks whether it may be; who takes the
  // module out says so and then looks whether the program waits. In one total order: at least one sees the
  // other.
  slot.released.store(mine, std::memory_order_seq_cst);
  if (slot.open.load(std::memory_order_seq_cst) == 0) {
    slot.done.store(mine, std::memory_order_release);
    return false;
  }
  slot.begun.store(slot.begun.load(relaxed) + 1, relaxed);
  return true;
}

/// By a program that is dispatched at once: the first instant at which it may release itself again.
inline std::int64_t not_before_ns(const ReleaseSlot& slot) noexcept {
  if (slot.begun.load(std::memory_order_relaxed) == 0) return 0;
  return slot.release_ns.load(std::memory_order_relaxed) + slot.interarrival_ns;
}

/// By the node, for a program that is not running and a module that is out of the tables.
inline void clear_for_new_program(ReleaseSlot& slot) noexcept {
  slot.phase.store(ReleaseSlotPhase::empty, std::memory_order_relaxed);
  slot.sleeping.store(0, std::memory_order_relaxed);
  slot.released.store(0, std::memory_order_relaxed);
  slot.done.store(0, std::memory_order_relaxed);
  slot.end.store(0, std::memory_order_relaxed);
  slot.body_ended_ns.store(0, std::memory_order_relaxed);
  slot.thread.store(0, std::memory_order_release);
}

}  // namespace takt::channel
