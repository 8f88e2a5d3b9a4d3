// Tests the release of process modules. Here a thread acts as the program of a process module. The thread and
// the executor share only the slot and the wake word.
#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>

#include <takt/os/futex.hpp>

#include "fake_device.hpp"

namespace takt::executor::process_test {
namespace {

using std::chrono::milliseconds;

TEST(ProcessModule, IsReleasedWithItsCycleNumberAndReleaseTime) {
  FakeDevice device{{process(milliseconds{2}), thread(milliseconds{1})}};
  device.join();
  device.cycle();
  channel::ReleaseSlot& slot = device.slots[0];
  EXPECT_EQ(slot.released.load(), 1U);
  EXPECT_EQ(slot.cycle(slot.released.load()), 0U);
  EXPECT_EQ(slot.release_ns.load(), to_ns(device.t0));
  slot.done.store(1);
  device.cycle();
  EXPECT_EQ(slot.released.load(), 1U) << "the program is not due";
  device.cycle();
  EXPECT_EQ(slot.released.load(), 2U);
  EXPECT_EQ(slot.cycle(slot.released.load()), 1U);
  EXPECT_EQ(slot.release_ns.load(), to_ns(device.t0 + milliseconds{2}));
  EXPECT_EQ(device.blocks[0].cycles.load(), 2U);
}

TEST(ProcessModule, CountsAnOverrunInsteadOfAReleaseWhileItsBodyRuns) {
  FakeDevice device{{process(milliseconds{1})}};
  device.join();
  for (int i = 0; i < 4; ++i) device.cycle();
  EXPECT_EQ(device.slots[0].released.load(), 1U);
  EXPECT_EQ(device.blocks[0].cycles.load(), 1U);
  EXPECT_EQ(device.blocks[0].overruns.load(), 3U);
  device.slots[0].done.store(1);
  device.cycle();
  EXPECT_EQ(device.slots[0].cycle(device.slots[0].released.load()), 4U)
      << "the cycle numbers skip every missed release";
}

TEST(ProcessModule, IsNotReleasedBeforeItsFirstWait) {
  FakeDevice device{{process(milliseconds{1})}};
  device.slots[0].phase.store(channel::ReleaseSlotPhase::attached);
  device.join();
  device.cycle();
  EXPECT_EQ(device.slots[0].released.load(), 0U);
  EXPECT_EQ(device.blocks[0].cycles.load(), 0U);
}

TEST(ProcessModule, IsNotReleasedWhileRemovedFromTheTables) {
  FakeDevice device{{process(milliseconds{1})}};
  device.blocks[0].in_tables.store(0);
  device.join();
  device.cycle();
  device.cycle(milliseconds{7});
  EXPECT_EQ(device.slots[0].released.load(), 0U);
  EXPECT_EQ(device.blocks[0].overruns.load(), 0U);
  EXPECT_EQ(device.blocks[0].missed.load(), 0U);
}

TEST(ProcessModule, IsWokenOnlyOnceWhileItSleeps) {
  FakeDevice device{{process(milliseconds{1}), process(milliseconds{1}), process(milliseconds{1})}};
  device.slots[0].sleeping.store(1);
  device.slots[2].sleeping.store(1);
  device.join();
  EXPECT_EQ(device.cycle(), channel::wake_bit(0) | channel::wake_bit(2));
  EXPECT_EQ(device.cycle(), 0U) << "its wake-up was already requested";
  EXPECT_EQ(device.blocks[0].cycles.load(), 1U);
  EXPECT_EQ(device.blocks[1].cycles.load(), 1U);
}

channel::Ticket ticket_of(const channel::ReleaseSlot& slot) {
  return channel::ticket_of(slot, {.count = slot.released.load()});
}

TEST(ProcessModule, FollowsTheProgramBeforeItInTheRow) {
  FakeDevice device{{process(milliseconds{1}, 9), process(milliseconds{2}, 5), process(milliseconds{1}, 1)}};
  device.join();
  device.cycle();
  EXPECT_EQ(ticket_of(device.slots[2]).after, 0U) << "it is the first in its row";
  EXPECT_EQ(ticket_of(device.slots[1]).after, ticket_of(device.slots[2]).number);
  EXPECT_EQ(ticket_of(device.slots[0]).after, ticket_of(device.slots[1]).number);
  for (std::size_t i = 0; i < 3; ++i) device.slots[i].done.store(1);
  device.cycle();
  EXPECT_EQ(ticket_of(device.slots[2]).after, 0U);
  EXPECT_EQ(ticket_of(device.slots[0]).after, ticket_of(device.slots[2]).number)
      << "the program between them is not due";
}

TEST(ProcessModule, FollowsNoProgramThatIsStillInItsBody) {
  FakeDevice device{{process(milliseconds{1}), process(milliseconds{1}), process(milliseconds{1})}};
  device.join();
  device.cycle();
  device.slots[0].done.store(1);
  device.slots[2].done.store(1);
  device.cycle();
  EXPECT_EQ(ticket_of(device.slots[2]).after, ticket_of(device.slots[0]).number);
}

TEST(ProcessModule, GetsNoTicketForAPendingRelease) {
  model::Module behind = process(milliseconds{1});
  behind.overrun = model::OverrunContract{.what = model::Overrun::catch_up, .limit = 3};
  FakeDevice device{{behind, process(milliseconds{1})}};
  device.join();
  device.cycle();
  device.slots[1].done.store(1);
  device.cycle();
  EXPECT_EQ(device.slots[0].released.load(), 2U);
  EXPECT_EQ(ticket_of(device.slots[0]).number, 0U);
  EXPECT_EQ(ticket_of(device.slots[1]).after, 0U) << "a pending release holds up no other program";
}

// The executor and the program run at independent speeds. They share only the words in shared memory that
// libtakt_process uses.
TEST(ProcessModule, ServesEachReleaseOnceAtAnyProgramSpeed) {
  constexpr std::uint64_t kReleases = 20'000;
  FakeDevice device{{process(milliseconds{1})}};
  channel::ReleaseSlot& slot = device.slots[0];
  channel::WakeWord wake_word{};
  std::atomic<std::uint64_t> sum{0};
  std::thread program{[&] {
    std::mt19937 random{3};
    std::uint32_t taken = 0;
    while (true) {
      slot.done.store(taken, std::memory_order_release);
      for (std::uint64_t i = random() % 300; i > 0 && slot.released.load(std::memory_order_acquire) == taken;
           --i) {
      }
      while (slot.released.load(std::memory_order_acquire) == taken) {
        if (slot.end.load(std::memory_order_acquire) != 0) return;
        const std::uint32_t rings = wake_word.rings.load();
        slot.sleeping.store(1);
        if (slot.released.load() == taken && slot.end.load() == 0)
          os::futex_wait(wake_word.rings, rings, slot.wake_bit);
        slot.sleeping.store(0);
      }
      EXPECT_EQ(slot.released.load(std::memory_order_acquire), taken + 1);
      taken = slot.released.load(std::memory_order_acquire);
      sum += slot.cycle(taken);
    }
  }};
  device.join();
  std::uint64_t expected = 0;
  std::uint64_t rings = 0;
  while (device.blocks[0].cycles.load() < kReleases) {
    const std::uint64_t row = device.executor->next_row();
    const std::uint64_t before = device.blocks[0].cycles.load();
    const std::uint32_t wake = device.cycle();
    if (device.blocks[0].cycles.load() != before) expected += row;
    if (wake != 0) {
      ++rings;
      wake_word.rings.fetch_add(1);
      os::futex_wake(wake_word.rings, wake);
    }
    std::this_thread::yield();
  }
  while (!slot.waiting()) std::this_thread::yield();
  slot.end.store(1);
  wake_word.rings.fetch_add(1);
  os::futex_wake(wake_word.rings, ~0U);
  program.join();
  EXPECT_EQ(sum.load(), expected);
  EXPECT_EQ(device.block->cycles.load(), device.blocks[0].cycles.load() + device.blocks[0].overruns.load());
  EXPECT_LE(rings, kReleases);
}

}  // namespace
}  // namespace takt::executor::process_test
