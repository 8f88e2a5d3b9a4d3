// The release slot of a process module: the shared memory through which the scheduler releases the module's
// program, and through which the program answers. Each program has its own slot, so a program that writes out
// of bounds harms no other. A release is one store by the scheduler. The end of a body is one store by the
// program.
//
// A program that does not find the expected release sleeps on the wake word. All programs of the device share
// this word, each with its own bit, so the scheduler needs one wake-up call per cycle, however many programs
// sleep.
//
// A sporadic program with immediate dispatch releases itself when an event has arrived: it writes to its own
// slot what the scheduler writes to the slots of other programs. So "released and not done" always means "in
// its body", and no row finds a program in between.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include <takt/channel/layout.hpp>
#include <takt/channel/saved_state.hpp>
#include <takt/core/statistics.hpp>

namespace takt::channel {

/// The word on which all sleepers of a device wait: a futex with bit sets. To wake sleepers, a thread
/// increments `rings` and wakes the futex with their bits.
struct WakeWord {
  std::atomic<std::uint32_t> rings;
  /// Bits to wake at the end of the cycle, because a sample was written for a sleeper. The writer takes them
  /// with take_pending() at the end of its cycle, and wakes these sleepers. SYNC: pending
  std::atomic<std::uint32_t> pending;
  /// One bit for each gateway (there is one per DDS domain) that sleeps or is about to. A sample for a
  /// gateway needs a wake-up only if the bit is set. SYNC: gateway sleeps
  std::atomic<std::uint32_t> gateway_sleeps;

  /// Adds the wake bits of a link to `pending`. Call it after publishing a sample on that link. A real-time
  /// thread may call it.
  void note(std::uint32_t wake_bits) noexcept;
  /// Returns the pending bits and clears them. Costs one load if there are none. A real-time thread may call
  /// it.
  std::uint32_t take_pending() noexcept {
    return pending.load(std::memory_order_seq_cst) == 0 ? 0 : pending.exchange(0, std::memory_order_seq_cst);
  }
};

/// The bits of the wake word: one for the threads of sporadic modules, one for the gateways, one for the
/// threads that handle requests. Programs share the other 29 bits in turn.
inline constexpr std::uint32_t kSporadicBit = 1U << 31;
inline constexpr std::uint32_t kGatewayBit = 1U << 30;
inline constexpr std::uint32_t kServiceBit = 1U << 29;
constexpr std::uint32_t wake_bit(std::size_t slot) { return 1U << (slot % 29); }

inline void WakeWord::note(std::uint32_t wake_bits) noexcept {
  if ((wake_bits & kGatewayBit) != 0 && gateway_sleeps.load(std::memory_order_seq_cst) == 0)
    wake_bits &= ~kGatewayBit;
  if (wake_bits != 0) pending.fetch_or(wake_bits, std::memory_order_seq_cst);
}

/// No program can have this many pending releases.
inline constexpr std::uint32_t kMaxPending = 1U << 16;

enum class ReleaseSlotKind : std::uint32_t { periodic, sporadic, unscheduled };
enum class ReleaseSlotPhase : std::uint32_t {
  empty,     ///< no program, or it has not called initPeriodExe() or initSporadicExe() yet
  attached,  ///< the program has called initPeriodExe() or initSporadicExe()
  ready,     ///< the program has reached its first waitPeriod() or waitSporadic()
};

struct alignas(64) ReleaseSlot {
  static constexpr std::uint64_t kMagic = 0x7365'6174'0000'0006;  // layout 6

  // The node writes these fields before the program starts.
  std::uint64_t magic;
  Name name;
  ReleaseSlotKind kind;
  std::uint32_t wake_bit;
  std::int64_t period_ns;      ///< time between two releases
  std::int64_t offset_ns;      ///< time from T0 to the first release
  std::int64_t margin_cap_ns;  ///< the longest time that the program may spin before a release
  std::uint32_t lock_memory;
  std::int64_t deadline_ns;  ///< for a sporadic program: the time allowed from its release to its next wait;
                             ///< 0: no deadline
  std::uint32_t immediate;   ///< 1: the program releases itself with begin(); 0: the scheduler releases it
  std::int64_t interarrival_ns;  ///< for a program with `immediate`: the shortest time between two releases
  std::uint32_t logical;   ///< 1: timing="let": the program reads inputs as of its release, and its outputs
                           ///< become valid at the period's end
  std::uint32_t catch_up;  ///< how many releases may be pending while the program is in its body

  // The scheduler writes these fields, or the program if it releases itself.
  alignas(64) std::atomic<std::uint32_t> released;  ///< number of releases so far. SYNC: released, publishes
                                                    ///< `cycles` and `release_ns`
  /// The cycle numbers of the last two releases. Release number n is at index n modulo 2, so a new release
  /// does not overwrite the number that the program is reading.
  std::array<std::atomic<std::uint64_t>, 2> cycles;
  std::atomic<std::int64_t> release_ns;  ///< instant of the last release
  std::atomic<std::uint32_t> end;        ///< written by the node: the program must end
  std::atomic<std::uint32_t> open;       ///< written by the node: the module is in the tables, so the program
                                         ///< may release itself. SYNC: open
  std::atomic<std::int64_t> t0_ns;       ///< written by the node: T0 of the rows

  // The program writes these fields.
  alignas(64) std::atomic<std::uint32_t> done;  ///< number of the last finished release. SYNC: done
  std::atomic<std::uint32_t> sleeping;          ///< the program sleeps or is about to. SYNC: sleeping
  std::atomic<ReleaseSlotPhase> phase;
  std::atomic<std::int32_t> thread;
  std::atomic<std::int64_t> body_began_ns;  ///< when the last ended body began; written before `done`
  std::atomic<std::int64_t> body_ended_ns;
  std::atomic<std::int64_t> margin_ns;
  std::atomic<std::uint64_t>
      late;  ///< number of bodies that ended after the deadline. SYNC: late, publishes late_by_ns
  std::atomic<std::int64_t> late_by_ns;  ///< how long after its deadline the last late body ended
  std::atomic<std::uint64_t> begun;      ///< number of bodies for which the program released itself
  Statistics jitter;                     ///< Eq. (1), P_n - T_n, with T_n measured by the program
  Statistics run;
  SavedState saved;  ///< the program writes it after each body, the node while there is no program

  /// Whether the program was released and has not finished this release.
  [[nodiscard]] bool in_body() const noexcept {
    return done.load(std::memory_order_acquire) != released.load(std::memory_order_seq_cst);
  }
  /// Returns the cycle number of the release with number `count`, which must be the last one.
  [[nodiscard]] std::uint64_t cycle(std::uint32_t count) const noexcept {
    return cycles[count % 2].load(std::memory_order_acquire);
  }
  /// Whether the program has reached its first wait and is not in its body.
  [[nodiscard]] bool waiting() const noexcept {
    return phase.load(std::memory_order_acquire) == ReleaseSlotPhase::ready && !in_body();
  }
};

enum class Release {
  given,    ///< the program is awake and sees the release
  wake,     ///< the program sleeps: the caller must wake its bit of the wake word
  pending,  ///< the program is still in its body and serves this release afterwards
  busy,     ///< the program is absent or still in its body, so one release is dropped: this one, or with
            ///< catch_up the oldest pending one
};

/// Releases the program. The scheduler calls it. It takes no lock and makes no system call, so it is safe in
/// a real-time thread.
inline Release release(ReleaseSlot& slot, std::uint64_t cycle, std::int64_t release_ns) noexcept {
  const std::uint32_t count = slot.released.load(std::memory_order_relaxed) + 1;
  if (!slot.waiting()) {
    if (slot.catch_up == 0 || slot.phase.load(std::memory_order_acquire) != ReleaseSlotPhase::ready)
      return Release::busy;
    const std::uint32_t pending = count - 2 - slot.done.load(std::memory_order_acquire);
    // If the body ends meanwhile, the program still serves the newest releases, including this one.
    if (pending >= slot.catch_up && pending < kMaxPending) {
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
  // SYNC: released and sleeping. The scheduler and the program each store their own word and then load the
  // word of the other, in one total order. So either the scheduler sees that the program sleeps, or the
  // program sees the release before it sleeps.
  slot.released.store(count, std::memory_order_seq_cst);
  return slot.sleeping.load(std::memory_order_seq_cst) != 0 ? Release::wake : Release::given;
}

/// A release that the program took from its slot.
struct Taken {
  std::uint32_t count = 0;
  std::uint64_t cycle = 0;
  std::int64_t release_ns = 0;
};

/// Returns the next release after `done`; there must be one. Releases that became pending during the body are
/// returned one by one, the oldest first. Their cycle numbers are consecutive and end with that of the newest
/// release. The program calls this function. A real-time thread may call it.
inline Taken take(const ReleaseSlot& slot, std::uint32_t done) noexcept {
  while (true) {
    const std::uint32_t count = slot.released.load(std::memory_order_acquire);  // SYNC: released
    const std::uint64_t newest = slot.cycle(count);
    const std::int64_t release_ns = slot.release_ns.load(std::memory_order_acquire);
    const std::uint64_t later = count - done - 1;  // number of releases after the taken one
    if (slot.released.load(std::memory_order_relaxed) != count)
      continue;  // another release arrived: try again
    if (slot.catch_up == 0) return {count, newest, release_ns};
    const std::uint64_t cycle = newest - later;
    return {done + 1, cycle,
            slot.t0_ns.load(std::memory_order_relaxed) + slot.offset_ns +
                static_cast<std::int64_t>(cycle) * slot.period_ns};
  }
}

/// Releases the calling program at `now_ns`. A program with immediate dispatch calls it when an event has
/// arrived and the program's interarrival time has passed. Returns false, without a release, if the module is
/// not in the tables. A real-time thread may call it.
inline bool begin(ReleaseSlot& slot, std::int64_t now_ns) noexcept {
  constexpr auto relaxed = std::memory_order_relaxed;
  if (slot.open.load(relaxed) == 0) return false;
  // The release gets the cycle number of the next row, as if that row had released the program.
  const std::int64_t since_t0 = now_ns - slot.t0_ns.load(relaxed);
  const bool rows = slot.period_ns > 0 && since_t0 > 0;
  const std::int64_t row = rows ? (since_t0 + slot.period_ns - 1) / slot.period_ns : 0;
  const std::uint32_t mine = slot.released.load(relaxed) + 1;
  slot.cycles[mine % 2].store(static_cast<std::uint64_t>(row), relaxed);
  slot.release_ns.store(now_ns, relaxed);
  // SYNC: open. The program announces that it is in its body, and then checks whether the slot is still open.
  // A node that removes the module closes the slot, and then checks whether the program waits. These steps
  // have one total order, so the program sees that the slot is closed, or the node sees that the program is
  // in its body.
  slot.released.store(mine, std::memory_order_seq_cst);
  if (slot.open.load(std::memory_order_seq_cst) == 0) {
    slot.done.store(mine, std::memory_order_release);
    return false;
  }
  slot.begun.store(slot.begun.load(relaxed) + 1, relaxed);
  return true;
}

/// Returns the first instant at which a program with immediate dispatch may release itself again, in ns of
/// the monotonic clock. The program calls this function.
inline std::int64_t not_before_ns(const ReleaseSlot& slot) noexcept {
  if (slot.begun.load(std::memory_order_relaxed) == 0) return 0;
  return slot.release_ns.load(std::memory_order_relaxed) + slot.interarrival_ns;
}

/// Prepares the slot for a new program. The node calls it while no program runs and the module is out of the
/// tables.
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
