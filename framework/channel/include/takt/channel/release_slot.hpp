// The release slot of a process module: the shared memory through which the scheduler releases the module's
// program, and through which the program answers. Each program has its own slot, and can write only its
// answers. So a program that writes out of bounds harms neither another program nor the scheduler. A release
// is one store by the scheduler. The end of a body is one store by the program.
//
// A program that does not find the expected release sleeps on the wake word. All process modules of the
// device share this word, each with its own bit, so the scheduler needs one wake-up call per cycle, however
// many programs sleep.
//
// A sporadic process module with immediate dispatch releases itself when an event has arrived: it writes the
// same words to its own slot that the scheduler writes to the slots of other programs. So a program that is
// released and not done is always in its body, and a row never finds the program in an intermediate state.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include <takt/channel/layout.hpp>
#include <takt/channel/log_ring.hpp>
#include <takt/channel/property_mailbox.hpp>
#include <takt/channel/saved_state.hpp>
#include <takt/channel/turn.hpp>
#include <takt/core/statistics.hpp>

namespace takt::channel {

/// Separates memory that a program may only read from memory that it may write, because only whole pages can
/// be protected. No supported machine has larger pages.
using PageGap = std::array<std::byte, 64 * 1024>;

/// Collects which sleeping readers to wake at the end of a cycle. Compiled components access the members
/// directly, so they depend on this layout.
struct WakeBits {
  std::uint32_t unused;
  /// The bits to wake at the end of the cycle, because a sample was written for a sleeping reader. At the end
  /// of its cycle, each thread that writes samples takes all bits with take_pending(), also those of other
  /// threads, and wakes their readers.
  std::atomic<std::uint32_t> pending;
  /// One bit for each gateway (there is one per DDS domain) that sleeps or is about to sleep. A sample for a
  /// gateway needs a wake-up only if the gateway's bit is set. The gateway sets its bit before it checks for
  /// samples a last time.
  std::atomic<std::uint32_t> gateway_sleeps;

  /// Adds the wake bits of a link to `pending`. Call it after publishing a sample on that link. A real-time
  /// thread may call it.
  void note(std::uint32_t wake_bits) noexcept {
    if (const std::uint32_t needed = without_awake_gateways(wake_bits); needed != 0)
      pending.fetch_or(needed, std::memory_order_seq_cst);
  }
  /// Returns the bits without that of the gateways if no gateway sleeps. A real-time thread may call it.
  [[nodiscard]] std::uint32_t without_awake_gateways(std::uint32_t wake_bits) const noexcept;
  /// Returns the pending bits and clears them. Costs one load if no bit is set. A real-time thread may call
  /// it.
  std::uint32_t take_pending() noexcept {
    return pending.load(std::memory_order_seq_cst) == 0 ? 0 : pending.exchange(0, std::memory_order_seq_cst);
  }
};

/// The word on which all sleeping threads of a device wait: a futex with bit sets. To wake some of the
/// threads, another thread rings the wake word: it increments `rings` and wakes the futex with their bits.
struct WakeWord : WakeBits {
  PageGap gap;
  /// Programs can write only this member. Every value of it is valid.
  std::atomic<std::uint32_t> rings;

  /// The size of the first part, which programs can only read.
  static constexpr std::size_t kReadOnly = sizeof(WakeBits) + sizeof(PageGap);
};

/// The bits of the wake word: one for the threads of sporadic modules, one for the gateways, one for the
/// threads that handle requests. Process modules share the other 29 bits: the slot with index n has bit n
/// modulo 29.
inline constexpr std::uint32_t kSporadicBit = 1U << 31;
inline constexpr std::uint32_t kGatewayBit = 1U << 30;
inline constexpr std::uint32_t kServiceBit = 1U << 29;
constexpr std::uint32_t wake_bit(std::size_t slot) { return 1U << (slot % 29); }

inline std::uint32_t WakeBits::without_awake_gateways(std::uint32_t wake_bits) const noexcept {
  const bool awake = (wake_bits & kGatewayBit) != 0 && gateway_sleeps.load(std::memory_order_seq_cst) == 0;
  return awake ? wake_bits & ~kGatewayBit : wake_bits;
}

/// An upper limit for the number of pending releases. If the computed number is larger, the difference of the
/// counters was negative and has wrapped around.
inline constexpr std::uint32_t kMaxPending = 1U << 16;

enum class ReleaseSlotKind : std::uint32_t { periodic, sporadic, unscheduled };
enum class ReleaseSlotPhase : std::uint32_t {
  empty,     ///< no program runs, or it has not yet called initPeriodExe() or initSporadicExe()
  attached,  ///< the program has called initPeriodExe() or initSporadicExe()
  ready,     ///< the program has reached its first waitPeriod() or waitSporadic()
};

struct alignas(64) ReleaseSlot {
  static constexpr std::uint64_t kMagic = 0x7365'6174'0000'000a;  // layout 10

  // The node writes these fields before the program starts.
  std::uint64_t magic;
  Name name;
  ReleaseSlotKind kind;
  std::uint32_t wake_bit;
  std::int64_t period_ns;      ///< time between two releases
  std::int64_t offset_ns;      ///< time from T0 to the first release
  std::int64_t margin_cap_ns;  ///< the longest time that the program may spin before, and again after, the
                               ///< expected release
  std::uint32_t lock_memory;
  std::int64_t deadline_ns;  ///< for a sporadic module: the longest time from its release to its next wait;
                             ///< 0: no deadline
  std::uint32_t immediate;   ///< 1: the program releases itself with begin(); 0: the scheduler releases it
  std::int64_t interarrival_ns;  ///< with `immediate`: the shortest time between two releases
  std::uint32_t logical;   ///< 1: timing="let": the program reads its inputs as they were at its release, and
                           ///< its outputs become valid at the end of the period
  std::uint32_t catch_up;  ///< the number of releases that may be pending while the program is in its body

  // The node writes these fields at any time.
  std::atomic<std::uint32_t> end;   ///< 1: the program must end
  std::atomic<std::uint32_t> open;  ///< 1 while the module is in the tables, so that the program may release
                                    ///< itself
  std::atomic<std::int64_t> t0_ns;  ///< T0 of the rows
  PropertyRequest property_request;
  PageGap gap_before_releases;

  // The scheduler writes these fields, or the program if it releases itself.
  alignas(64) std::atomic<std::uint32_t> released;  ///< number of releases so far; stored after `cycles`,
                                                    ///< `release_ns` and the ticket
  std::atomic<std::uint32_t> ticket_of;             ///< the number of the release to which the ticket belongs
  /// The cycle numbers of the last two releases. Release number n is at index n modulo 2, so a new release
  /// does not overwrite the number that the program is reading.
  std::array<std::atomic<std::uint64_t>, 2> cycles;
  std::atomic<std::int64_t> release_ns;  ///< instant of the last release
  std::atomic<std::uint32_t> ticket;
  std::atomic<std::uint32_t> ticket_after;
  PageGap gap_before_answers;

  // The program writes these fields.
  alignas(64) std::atomic<std::uint32_t> done;  ///< number of the last finished release
  std::atomic<std::uint32_t> sleeping;          ///< 1: the program sleeps or is about to sleep
  std::atomic<ReleaseSlotPhase> phase;
  std::atomic<std::int32_t> thread;
  std::atomic<std::int64_t> body_began_ns;  ///< when the last ended body began; written before `done`
  std::atomic<std::int64_t> body_ended_ns;
  std::atomic<std::int64_t> margin_ns;
  std::atomic<std::uint64_t>
      late;  ///< number of bodies that ended after the deadline; stored after late_by_ns
  std::atomic<std::int64_t> late_by_ns;  ///< how long after its deadline the last late body ended
  std::atomic<std::uint64_t> begun;      ///< number of bodies for which the program released itself
  Statistics jitter;                     ///< P_n - T_n of the paper's Eq. (1), with T_n measured by the
                                         ///< program
  Statistics run;
  PropertyAnswer property_answer;  ///< a thread of the program that is not real-time writes it
  SavedState saved;  ///< the program writes it after each body; the node writes it while no program runs
  LogRing log;

  /// Returns the size of the first part of the slot, which the program can only read. For a program with
  /// immediate dispatch this part is smaller, because this program also writes its releases.
  [[nodiscard]] std::size_t read_only_size() const noexcept {
    return immediate != 0 ? offsetof(ReleaseSlot, released) : offsetof(ReleaseSlot, done);
  }
  /// True if the program was released and has not finished this release.
  [[nodiscard]] bool in_body() const noexcept {
    return done.load(std::memory_order_acquire) != released.load(std::memory_order_seq_cst);
  }
  /// Returns the cycle number of the release with number `count`, which must be the last one.
  [[nodiscard]] std::uint64_t cycle(std::uint32_t count) const noexcept {
    return cycles[count % 2].load(std::memory_order_acquire);
  }
  /// True if the program has called its wait function and is not in its body.
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

/// Releases the program. If the program waits, the release gets `*ticket` (see turn.hpp), and `*ticket`
/// becomes the ticket of the next release in the row. A pending release gets no ticket, because its body
/// begins directly after the program's current body. The scheduler calls release(). The function takes no
/// lock and makes no system call, so a real-time thread may call it.
inline Release release(ReleaseSlot& slot, std::uint64_t cycle, std::int64_t release_ns,
                       Ticket* ticket = nullptr) noexcept {
  const std::uint32_t count = slot.released.load(std::memory_order_relaxed) + 1;
  if (!slot.waiting()) {
    if (slot.catch_up == 0 || slot.phase.load(std::memory_order_acquire) != ReleaseSlotPhase::ready)
      return Release::busy;
    const std::uint32_t pending = count - 2 - slot.done.load(std::memory_order_acquire);
    // If the body ends before the store below, the program still serves the newest releases, including this
    // one.
    // The program may be in take(). If it sees a cycle number stored here, it also sees in `released` that
    // another release arrived.
    if (pending >= slot.catch_up && pending < kMaxPending) {
      slot.cycles[(count - 1) % 2].store(cycle, std::memory_order_release);
      return Release::busy;
    }
    slot.cycles[count % 2].store(cycle, std::memory_order_release);
    slot.release_ns.store(release_ns, std::memory_order_relaxed);
    slot.released.store(count, std::memory_order_seq_cst);
    return slot.sleeping.load(std::memory_order_seq_cst) != 0 ? Release::wake : Release::pending;
  }
  slot.cycles[count % 2].store(cycle, std::memory_order_relaxed);
  slot.release_ns.store(release_ns, std::memory_order_relaxed);
  if (ticket != nullptr) {
    slot.ticket_of.store(count, std::memory_order_relaxed);
    slot.ticket.store(ticket->number, std::memory_order_relaxed);
    slot.ticket_after.store(ticket->after, std::memory_order_relaxed);
    *ticket = ticket->next();
  }
  // The scheduler stores `released` and then loads `sleeping`; the program stores `sleeping` and then loads
  // `released`. All four accesses have one total order. So either the scheduler sees that the program sleeps,
  // or the program sees the release before it sleeps.
  slot.released.store(count, std::memory_order_seq_cst);
  return slot.sleeping.load(std::memory_order_seq_cst) != 0 ? Release::wake : Release::given;
}

/// A release that the program took from its slot.
struct Taken {
  std::uint32_t count = 0;
  std::uint64_t cycle = 0;
  std::int64_t release_ns = 0;
};

/// Returns the ticket of a release that the program took. The ticket is still valid, because the scheduler
/// writes the next ticket only after the program has finished this release. The program calls this function.
/// A real-time thread may call it.
inline Ticket ticket_of(const ReleaseSlot& slot, const Taken& taken) noexcept {
  if (slot.ticket_of.load(std::memory_order_relaxed) != taken.count) return {};
  return {.number = slot.ticket.load(std::memory_order_relaxed),
          .after = slot.ticket_after.load(std::memory_order_relaxed)};
}

/// Returns the next release after `done`; there must be one. Releases that became pending during the body are
/// returned one by one, the oldest first. Their cycle numbers are consecutive and end with that of the newest
/// release. The program calls this function. A real-time thread may call it.
inline Taken take(const ReleaseSlot& slot, std::uint32_t done) noexcept {
  while (true) {
    const std::uint32_t count = slot.released.load(std::memory_order_acquire);  // see release()
    const std::uint64_t newest = slot.cycle(count);
    const std::int64_t release_ns = slot.release_ns.load(std::memory_order_acquire);
    const std::uint64_t later = count - done - 1;  // number of releases after the one that is taken
    if (slot.released.load(std::memory_order_relaxed) != count)
      continue;  // another release arrived: try again
    if (slot.catch_up == 0) return {count, newest, release_ns};
    const std::uint64_t cycle = newest - later;
    return {done + 1, cycle,
            slot.t0_ns.load(std::memory_order_relaxed) + slot.offset_ns +
                static_cast<std::int64_t>(cycle) * slot.period_ns};
  }
}

/// Releases the calling program at `now_ns`. A program with immediate dispatch calls begin() when an event
/// has arrived and the interarrival time has passed. Returns false, without a release, if the module is not
/// in the tables. A real-time thread may call it.
inline bool begin(ReleaseSlot& slot, std::int64_t now_ns) noexcept {
  constexpr auto relaxed = std::memory_order_relaxed;
  // If the module has just been put into the tables, the program also sees their T0.
  if (slot.open.load(std::memory_order_acquire) == 0) return false;
  // The release gets the cycle number of the next row, as if that row had released the program.
  const std::int64_t since_t0 = now_ns - slot.t0_ns.load(relaxed);
  const bool rows = slot.period_ns > 0 && since_t0 > 0;
  const std::int64_t row = rows ? (since_t0 + slot.period_ns - 1) / slot.period_ns : 0;
  const std::uint32_t mine = slot.released.load(relaxed) + 1;
  slot.cycles[mine % 2].store(static_cast<std::uint64_t>(row), relaxed);
  slot.release_ns.store(now_ns, relaxed);
  // The program announces that it is in its body, and then checks whether the slot is still open. A node that
  // removes the module closes the slot, and then checks whether the program waits. These four steps have one
  // total order. So either the program sees that the slot is closed, or the node sees that the program is in
  // its body.
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
  slot.ticket_of.store(0, std::memory_order_relaxed);
  slot.done.store(0, std::memory_order_relaxed);
  slot.end.store(0, std::memory_order_relaxed);
  slot.body_ended_ns.store(0, std::memory_order_relaxed);
  slot.property_request.number.store(0, std::memory_order_relaxed);
  slot.property_answer.serves.store(0, std::memory_order_relaxed);
  slot.property_answer.number.store(0, std::memory_order_relaxed);
  slot.thread.store(0, std::memory_order_release);
}

}  // namespace takt::channel
