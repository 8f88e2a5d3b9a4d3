#include <takt/channel/turn.hpp>

#include <thread>

#include <takt/channel/release_slot.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>

namespace takt::channel {

void Turn::await(const Ticket& ticket, Nanoseconds patience, WakeWord& wake_word, std::uint32_t wake_bit,
                 const std::atomic<std::uint32_t>& end) noexcept {
  if (reached(ticket)) return;
  Instant until = os::now() + patience;
  while (end.load(std::memory_order_seq_cst) == 0) {
    const std::uint32_t rings = wake_word.rings.load(std::memory_order_seq_cst);
    // This program announces that it waits, and then checks whether the previous program in the row has begun
    // its body. The previous program announces that its body begins, and checks at the end of the body which
    // programs wait. So either this program sees that the body has begun, or the previous program sees that
    // this program waits.
    waiting.fetch_or(wake_bit, std::memory_order_seq_cst);
    if (reached(ticket)) return;
    os::futex_wait(wake_word.rings, rings, wake_bit, until);
    if (reached(ticket)) return;
    if (os::now() < until) continue;
    // Perhaps another thread kept the CPU from this program, or from the executor before it could wake the
    // previous program. So every program that can run goes first.
    const std::uint32_t before = last.load(std::memory_order_seq_cst);
    wake_word.rings.fetch_add(1, std::memory_order_seq_cst);
    os::futex_wake(wake_word.rings, ~0U);
    std::this_thread::yield();
    if (reached(ticket) || last.load(std::memory_order_seq_cst) == before) return;
    until = os::now() + patience;
  }
}

}  // namespace takt::channel
