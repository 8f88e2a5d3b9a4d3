// Makes the process modules that share one CPU begin their bodies in the order of the table. Their priorities
// alone do not ensure this: a program that spins for its release begins at once, although the previous
// program in the table still sleeps.
//
// Each release gets a ticket with a number and with the number of the release before it in the same row. A
// program begins its body once the body of the previous release has begun. Until then the program sleeps,
// because otherwise it could keep the CPU from the program for which it waits.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include <takt/core/time.hpp>

namespace takt::channel {

struct WakeWord;

struct Ticket {
  std::uint32_t number = 0;  ///< 0: the release has no ticket, so its body begins at once
  std::uint32_t after = 0;   ///< the ticket whose body must begin before this one; 0: none

  /// The ticket of the next release in the same row.
  [[nodiscard]] constexpr Ticket next() const noexcept {
    const std::uint32_t following = number + 1;
    return {.number = following == 0 ? 1 : following, .after = number};
  }
};

/// The state that the periodic process modules of one executor share. Each begin() overwrites a number in
/// `begun`. So if a program writes out of bounds and damages `begun`, a wrong value lasts for kMostTickets
/// releases at most.
struct alignas(64) Turn {
  static constexpr std::uint32_t kMostTickets = 64;

  /// The body of ticket n stores n at index n modulo kMostTickets. A single number would not do: the first
  /// program of the next row waits for nobody, so it may begin before a program of this row.
  std::array<std::atomic<std::uint32_t>, kMostTickets> begun;
  std::atomic<std::uint32_t> last;     ///< the ticket of the last body that began
  std::atomic<std::uint32_t> waiting;  ///< the wake bits of the programs that sleep until their turn

  /// True if the body of ticket `ticket.after` has begun. Then `begun` contains this ticket or, if this
  /// program is very late, the ticket that has overwritten it.
  [[nodiscard]] bool reached(const Ticket& ticket) const noexcept {
    const std::uint32_t number = begun[ticket.after % kMostTickets].load(std::memory_order_seq_cst);
    return ticket.after == 0 || number == ticket.after || number == ticket.after + kMostTickets;
  }

  /// Waits until it is the ticket's turn. Stops waiting as soon as `end` is not 0. Also stops if, `patience`
  /// after the call, every program that can run has gone first and none has begun: the previous program may
  /// have died. Costs one load if it is already the ticket's turn; otherwise the program sleeps. The program
  /// calls this function. A real-time thread may call it.
  void await(const Ticket& ticket, Nanoseconds patience, WakeWord& wake_word, std::uint32_t wake_bit,
             const std::atomic<std::uint32_t>& end) noexcept;

  /// Announces that the body begins. The next program may be sleeping until its turn. It shares the CPU and
  /// could not run earlier than the end of this body, so it is woken only then. The program calls this
  /// function. A real-time thread may call it.
  void begin(const Ticket& ticket) noexcept {
    if (ticket.number == 0) return;
    begun[ticket.number % kMostTickets].store(ticket.number, std::memory_order_seq_cst);  // see await()
    last.store(ticket.number, std::memory_order_seq_cst);
  }

  /// Returns the wake bits of the programs that sleep until their turn, and clears these bits. The caller
  /// wakes the programs at the end of its body. Costs one load if no program waits. A real-time thread may
  /// call it.
  [[nodiscard]] std::uint32_t take_waiting() noexcept {
    return waiting.load(std::memory_order_seq_cst) == 0 ? 0 : waiting.exchange(0, std::memory_order_seq_cst);
  }
};

}  // namespace takt::channel
