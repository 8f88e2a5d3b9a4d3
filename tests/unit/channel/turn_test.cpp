#include <takt/channel/turn.hpp>

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <functional>
#include <random>
#include <thread>
#include <vector>

#include <takt/channel/release_slot.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/machine.hpp>
#include <takt/os/real_time.hpp>
#include <full_form.hpp>

namespace takt::channel::turn_test {
namespace {

using std::chrono::seconds;

TEST(Turn, ComesAtOnceForTheFirstProgramOfARow) {
  const Turn turn{};
  EXPECT_TRUE(turn.reached({}));
  EXPECT_TRUE(turn.reached({.number = 7, .after = 0}));
}

TEST(Turn, ComesOnceThePreviousBodyHasBegun) {
  Turn turn{};
  const Ticket first{.number = 7};
  const Ticket second = first.next();
  EXPECT_FALSE(turn.reached(second));
  turn.begin(first);
  EXPECT_TRUE(turn.reached(second));
  EXPECT_FALSE(turn.reached(second.next()));
  turn.begin(second);
  EXPECT_TRUE(turn.reached(second.next()));
}

TEST(Turn, WaitsForTheRowsOwnProgramThoughTheNextRowHasBegun) {
  Turn turn{};
  const Ticket first{.number = 7};
  const Ticket second = first.next();
  const Ticket third = second.next();
  const Ticket first_of_next_row{.number = third.number + 1};
  turn.begin(first);
  turn.begin(first_of_next_row);
  EXPECT_TRUE(turn.reached(second));
  EXPECT_FALSE(turn.reached(third));
  turn.begin(second);
  EXPECT_TRUE(turn.reached(third));
}

TEST(Turn, ComesForAProgramManyRowsLate) {
  Turn turn{};
  const Ticket first{.number = 7};
  turn.begin(first);
  turn.begin({.number = first.number + Turn::kMostTickets});
  EXPECT_TRUE(turn.reached(first.next()));
}

TEST(Turn, IsNotChangedByAReleaseWithoutATicket) {
  Turn turn{};
  turn.begin({.number = 7});
  turn.begin({});
  EXPECT_EQ(turn.last.load(), 7U);
  EXPECT_FALSE(turn.reached({.number = 9, .after = 8}));
}

TEST(Turn, ComesEvenIfTheTicketNumbersWrapAround) {
  Turn turn{};
  const Ticket last{.number = ~0U};
  turn.begin({.number = last.number - 1});
  EXPECT_EQ(last.next().number, 1U) << "0 means that there is no ticket";
  EXPECT_FALSE(turn.reached(last.next()));
  turn.begin(last);
  EXPECT_TRUE(turn.reached(last.next()));
  turn.begin(last.next());
  EXPECT_TRUE(turn.reached(last.next()))
      << "a program that begins late finds that later programs have begun already";
}

TEST(Turn, IgnoresTicketNumbersOfAnEarlierHost) {
  Turn turn{};
  turn.begin({.number = 1'000'000});
  const Ticket first{.number = 1};
  EXPECT_FALSE(turn.reached(first.next()));
  turn.begin(first);
  EXPECT_TRUE(turn.reached(first.next()));
}

TEST(Turn, WakesEachWaitingProgramOnce) {
  Turn turn{};
  turn.waiting.store(5);
  EXPECT_EQ(turn.take_waiting(), 5U);
  EXPECT_EQ(turn.take_waiting(), 0U);
}

TEST(Turn, IsAwaitedOnlyForALimitedTimeIfThePreviousProgramHasDied) {
  Turn turn{};
  WakeWord wake_word{};
  const std::atomic<std::uint32_t> end{0};
  const Instant before = os::now();
  turn.await({.number = 8, .after = 7}, std::chrono::milliseconds{2}, wake_word, wake_bit(0), end);
  EXPECT_GE(os::now() - before, std::chrono::milliseconds{2});
}

// While this program waits for its turn, other threads may keep the CPU from it for longer than its patience.
// They may keep the executor from waking the previous programs in the row for that long too.
TEST(Turn, LetsThePreviousProgramsBeginFirstThoughThePatienceHasEnded) {
  if (const auto may = os::may_have_priority(); !may) GTEST_SKIP() << to_text(may.problems());
  Turn turn{};
  WakeWord wake_word{};
  const std::atomic<std::uint32_t> end{0};
  const Ticket first{.number = 7};
  const Ticket second = first.next();
  const Ticket third = second.next();
  std::vector<std::uint32_t> began;  // the threads share one CPU, so it needs no lock
  std::atomic<int> asleep{0};
  const auto sleep_until_woken = [&](std::size_t index) {
    const std::uint32_t rings = wake_word.rings.load();
    ++asleep;
    os::futex_wait(wake_word.rings, rings, wake_bit(index));
  };
  const auto run = [&](const Ticket& ticket, std::size_t index, Nanoseconds patience) {
    turn.await(ticket, patience, wake_word, wake_bit(index), end);
    began.push_back(ticket.number);
    turn.begin(ticket);
    wake_word.rings.fetch_add(1);
    os::futex_wake(wake_word.rings, ~0U);
  };
  const os::Thread::Options options{
      .name = "program", .priority = 1, .cpus = {os::read_cpus().ordinary.front()}};
  Problems refused;
  {
    const auto first_program = os::Thread::start(
        options,
        [&] {
          sleep_until_woken(0);
          run(first, 0, seconds{60});
        },
        &refused);
    const auto second_program = os::Thread::start(
        options,
        [&] {
          sleep_until_woken(1);
          run(second, 1, seconds{60});
        },
        &refused);
    const auto third_program = os::Thread::start(
        options,
        [&] {
          // This thread cannot preempt the others. So once they have counted up `asleep`, they sleep.
          while (asleep < 2) os::sleep_until(os::now() + std::chrono::milliseconds{1});
          run(third, 2, Nanoseconds{0});
        },
        &refused);
  }
  EXPECT_TRUE(refused.empty()) << to_text(refused);
  EXPECT_EQ(began, (std::vector<std::uint32_t>{7, 8, 9}));
}

TEST(Turn, IsNoLongerAwaitedWhenTheProgramMustEnd) {
  Turn turn{};
  WakeWord wake_word{};
  const std::atomic<std::uint32_t> end{1};
  turn.await({.number = 8, .after = 7}, std::chrono::hours{1}, wake_word, wake_bit(0), end);
  EXPECT_FALSE(turn.reached({.number = 8, .after = 7}));
}

// Threads act as process modules. Each thread spins for a random time before it sleeps, so that the threads
// wake up in all orders. The counter `order`, not a clock, shows which body began first.
TEST(Turn, KeepsTheOrderOfTheRowAtAnyProgramSpeed) {
  constexpr std::uint32_t kRows = kSanitized ? 2'000 : 20'000;
  constexpr std::size_t kPrograms = 3;
  struct Program {
    ReleaseSlot slot{};
    std::vector<std::uint64_t> begins = std::vector<std::uint64_t>(kRows);
    std::thread thread;
  };
  std::array<Program, kPrograms> programs;
  Turn turn{};
  WakeWord wake_word{};
  std::atomic<std::uint64_t> order{0};
  const auto ring = [&](std::uint32_t bits) {
    wake_word.rings.fetch_add(1);
    os::futex_wake(wake_word.rings, bits);
  };
  const auto serve = [&](Program& program, unsigned seed) {
    ReleaseSlot& slot = program.slot;
    std::mt19937 random{seed};
    Taken taken;
    while (taken.count < kRows) {
      for (std::uint64_t i = random() % 300; i > 0 && slot.released.load() == taken.count; --i) {
      }
      while (slot.released.load() == taken.count) {
        const std::uint32_t rings = wake_word.rings.load();
        slot.sleeping.store(1);
        if (slot.released.load() == taken.count) os::futex_wait(wake_word.rings, rings, slot.wake_bit);
        slot.sleeping.store(0);
      }
      taken = take(slot, taken.count);
      const Ticket ticket = ticket_of(slot, taken);
      turn.await(ticket, seconds{60}, wake_word, slot.wake_bit, slot.end);
      program.begins[taken.count - 1] = ++order;
      turn.begin(ticket);
      if (const std::uint32_t bits = turn.take_waiting(); bits != 0) ring(bits);
      slot.done.store(taken.count);
    }
  };
  for (std::size_t i = 0; i < kPrograms; ++i) {
    programs[i].slot.wake_bit = wake_bit(i);
    programs[i].slot.phase.store(ReleaseSlotPhase::ready);
    programs[i].thread = std::thread{serve, std::ref(programs[i]), static_cast<unsigned>(i)};
  }
  Ticket ticket{.number = ~0U - kRows};  // the numbers wrap around to 0 in the middle of the test
  turn.begin({.number = ticket.number - 1});
  for (std::uint32_t row = 0; row < kRows; ++row) {
    for (const Program& program : programs) {
      while (!program.slot.waiting()) std::this_thread::yield();
    }
    ticket.after = 0;
    std::uint32_t bits = 0;
    for (Program& program : programs) {
      if (release(program.slot, row, 0, &ticket) == Release::wake) bits |= program.slot.wake_bit;
    }
    if (bits != 0) ring(bits);
  }
  for (Program& program : programs) program.thread.join();
  for (std::uint32_t row = 0; row < kRows; ++row) {
    for (std::size_t i = 0; i < kPrograms; ++i)
      ASSERT_EQ(programs[i].begins[row], row * kPrograms + i + 1) << "row " << row;
  }
}

}  // namespace
}  // namespace takt::channel::turn_test
