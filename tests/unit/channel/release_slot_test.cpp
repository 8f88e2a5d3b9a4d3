// Tests the release slot between two real processes: the scheduler, which releases, and a process module.
// Each of them adds up the cycle numbers of the releases, and the test compares the two sums at the end.
#include <takt/channel/release_slot.hpp>

#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include <full_form.hpp>

#include <atomic>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::channel::release_slot_test {
namespace {

constexpr std::uint32_t kReleases = kSanitized ? 20'000 : 200'000;

struct Shared {
  ReleaseSlot slot;
  WakeWord wake_word;
  std::atomic<std::uint64_t> served;
  std::atomic<std::uint64_t> sum;  // sum of the cycle numbers that the process module got
  // Number of releases that arrived twice, or with the release time of a different release.
  std::atomic<std::uint64_t> wrong;
  std::atomic<std::uint64_t> sleeps;
};

/// A process module that waits for releases as libtakt_process does. The module checks its slot `patience`
/// times before it sleeps.
class Program {
 public:
  Program(Shared& shared, int patience, bool stays_in_body = false) {
    pid_ = ::fork();
    if (pid_ == 0) {
      serve(shared, patience, stays_in_body);
      ::_exit(0);
    }
  }
  ~Program() { kill(); }
  void kill() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(std::exchange(pid_, 0), nullptr, 0);
  }
  [[nodiscard]] int wait() {
    int status = 0;
    ::waitpid(std::exchange(pid_, 0), &status, 0);
    return status;
  }

 private:
  static void serve(Shared& shared, int patience, bool stays_in_body) {
    ReleaseSlot& slot = shared.slot;
    std::uint32_t taken = 0;
    while (true) {
      slot.done.store(taken, std::memory_order_release);
      if (taken == 0) slot.phase.store(ReleaseSlotPhase::ready, std::memory_order_release);
      for (int i = 0; i < patience && slot.released.load(std::memory_order_acquire) == taken; ++i) {
      }
      while (slot.released.load(std::memory_order_acquire) == taken) {
        if (slot.end.load(std::memory_order_acquire) != 0) return;
        const std::uint32_t rings = shared.wake_word.rings.load();
        slot.sleeping.store(1);
        if (slot.released.load() == taken && slot.end.load() == 0) {
          ++shared.sleeps;
          os::futex_wait(shared.wake_word.rings, rings, slot.wake_bit);
        }
        slot.sleeping.store(0);
      }
      const std::uint32_t now = slot.released.load(std::memory_order_acquire);
      const std::uint64_t cycle = slot.cycle(slot.released.load());
      if (now != taken + 1) ++shared.wrong;
      if (slot.release_ns.load(std::memory_order_relaxed) != static_cast<std::int64_t>(cycle) * 1000)
        ++shared.wrong;
      taken = now;
      ++shared.served;
      shared.sum += cycle;
      while (stays_in_body) ::sched_yield();
    }
  }

  int pid_ = 0;
};

class ReleaseSlotBetweenTwoProcesses : public testing::Test {
 protected:
  ReleaseSlotBetweenTwoProcesses()
      : memory(std::move(os::SharedMemory::create("slot", sizeof(Shared)).value())),
        shared(*reinterpret_cast<Shared*>(memory.data())) {
    shared.slot.wake_bit = wake_bit(3);
  }

  void ring(std::uint32_t bits) {
    shared.wake_word.rings.fetch_add(1);
    os::futex_wake(shared.wake_word.rings, bits);
  }
  /// Waits until `holds` returns true. Returns false after ten seconds, because then a release was lost.
  template <class Predicate>
  bool until(const Predicate& holds) {
    const Instant limit = os::now() + std::chrono::seconds{10};
    while (!holds()) {
      if (os::now() > limit) return false;
      ::sched_yield();
    }
    return true;
  }
  /// Releases the process module `n` times, each time as soon as the module waits. Each attempt, successful
  /// or not, increments the cycle number.
  void release_times(std::uint32_t n) {
    for (std::uint32_t given = 0; given < n;) {
      const Release outcome = release(shared.slot, cycle, static_cast<std::int64_t>(cycle) * 1000);
      if (outcome == Release::busy) {
        ASSERT_TRUE(until([&] { return shared.slot.waiting(); })) << "release " << given << " was lost";
      } else {
        ++given;
        expected += cycle;
        if (outcome == Release::wake) ring(shared.slot.wake_bit);
      }
      ++cycle;
    }
    ASSERT_TRUE(until([&] { return shared.slot.waiting(); }));
  }
  void end(Program& program) {
    shared.slot.end.store(1);
    ring(~0U);
    EXPECT_EQ(program.wait(), 0);
  }

  os::SharedMemory memory;
  Shared& shared;
  std::uint64_t cycle = 0;
  std::uint64_t expected = 0;
};

TEST_F(ReleaseSlotBetweenTwoProcesses, DeliversEachReleaseExactlyOnce) {
  Program program{shared, 200};
  release_times(kReleases);
  end(program);
  EXPECT_EQ(shared.served.load(), kReleases);
  EXPECT_EQ(shared.sum.load(), expected);
  EXPECT_EQ(shared.wrong.load(), 0U);
}

TEST_F(ReleaseSlotBetweenTwoProcesses, DeliversEachReleaseToAProgramThatNeverSpins) {
  Program program{shared, 0};
  release_times(kReleases);
  end(program);
  EXPECT_EQ(shared.served.load(), kReleases);
  EXPECT_EQ(shared.sum.load(), expected);
  EXPECT_EQ(shared.wrong.load(), 0U);
  EXPECT_GT(shared.sleeps.load(), 0U);
}

TEST_F(ReleaseSlotBetweenTwoProcesses, IsUsableAfterTheProgramWasKilled) {
  for (const bool in_body : {true, false}) {
    clear_for_new_program(shared.slot);
    Program first{shared, 0, in_body};
    ASSERT_TRUE(until([&] { return shared.slot.waiting(); }));
    if (in_body) {
      const std::uint64_t before = shared.served.load();
      if (release(shared.slot, 0, 0) == Release::wake) ring(shared.slot.wake_bit);
      ASSERT_TRUE(until([&] { return shared.served.load() == before + 1; }));
    } else {
      ASSERT_TRUE(until([&] { return shared.slot.sleeping.load() != 0; }));
    }
    first.kill();
    if (in_body) {
      EXPECT_EQ(release(shared.slot, 1, 1000), Release::busy);
    }

    clear_for_new_program(shared.slot);
    EXPECT_EQ(release(shared.slot, 1, 1000), Release::busy) << "there is no program";
    EXPECT_EQ(shared.slot.sleeping.load(), 0U);
    Program second{shared, 10};
    ASSERT_TRUE(until([&] { return shared.slot.waiting(); }));
    const std::uint64_t before = shared.served.load();
    release_times(100);
    EXPECT_EQ(shared.served.load(), before + 100);
    EXPECT_EQ(shared.wrong.load(), 0U);
    end(second);
  }
}

TEST(ReleaseSlot, RejectsReleasesWithoutAProgram) {
  ReleaseSlot slot{};
  EXPECT_EQ(release(slot, 0, 0), Release::busy);
  EXPECT_EQ(slot.released.load(), 0U);
}

TEST(ReleaseSlot, SurvivesAnOverflowOfItsReleaseCount) {
  ReleaseSlot slot{};
  slot.phase.store(ReleaseSlotPhase::ready);
  slot.released.store(~0U);
  slot.done.store(~0U);
  EXPECT_EQ(release(slot, 1, 1), Release::given);
  EXPECT_EQ(slot.released.load(), 0U);
  EXPECT_EQ(release(slot, 2, 2), Release::busy);
  slot.done.store(0);
  EXPECT_EQ(release(slot, 2, 2), Release::given);
}

/// The release slot of a process module with immediate dispatch: libtakt_process, not the executor, releases
/// such a module. Here a thread acts as the process module, so that ThreadSanitizer finds data that the
/// module and the node share without synchronization.
class SelfReleasingProgram : public testing::Test {
 protected:
  static constexpr std::int64_t kInterarrival = 1'000;

  void SetUp() override {
    slot.wake_bit = wake_bit(1);
    slot.immediate = 1;
    slot.period_ns = 1'000'000;
    slot.interarrival_ns = kInterarrival;
    slot.phase.store(ReleaseSlotPhase::ready);
  }

  ReleaseSlot slot{};
};

TEST_F(SelfReleasingProgram, CountsAsWaitingExceptDuringItsBody) {
  slot.open.store(1);
  EXPECT_TRUE(slot.waiting());
  ASSERT_TRUE(begin(slot, 5'000'000));
  EXPECT_FALSE(slot.waiting());
  EXPECT_EQ(slot.release_ns.load(), 5'000'000)
      << "the deadline and the detection of a hang count from this time";
  EXPECT_EQ(slot.begun.load(), 1U);
  slot.done.store(slot.released.load());
  EXPECT_TRUE(slot.waiting());
}

TEST_F(SelfReleasingProgram, DoesNotBeginWhileRemovedFromTheTables) {
  EXPECT_FALSE(begin(slot, 5));
  EXPECT_TRUE(slot.waiting());
  EXPECT_EQ(slot.begun.load(), 0U);
}

TEST_F(SelfReleasingProgram, GetsTheCycleNumberOfTheNextRow) {
  slot.open.store(1);
  slot.t0_ns.store(10'000'000);
  for (const auto& [now, row] :
       {std::pair{9'000'000, 0U}, {10'000'000, 0U}, {10'000'001, 1U}, {11'000'000, 1U}, {11'000'001, 2U}}) {
    ASSERT_TRUE(begin(slot, now));
    EXPECT_EQ(slot.cycle(slot.released.load()), row) << now;
    slot.done.store(slot.released.load());
  }
}

TEST_F(SelfReleasingProgram, KeepsTheInterarrivalTimeAcrossARestart) {
  slot.open.store(1);
  EXPECT_EQ(not_before_ns(slot), 0);
  ASSERT_TRUE(begin(slot, 5'000'000));
  EXPECT_EQ(not_before_ns(slot), 5'000'000 + kInterarrival);
  clear_for_new_program(slot);
  EXPECT_EQ(not_before_ns(slot), 5'000'000 + kInterarrival);
  EXPECT_EQ(slot.begun.load(), 1U) << "the count continues";
}

// The body of the process module writes `shared`. The test's thread, which acts as the node, also writes
// `shared` while the module is out of the tables. Only the release slot prevents simultaneous writes.
TEST_F(SelfReleasingProgram, NeverRunsItsBodyWhileItsSlotIsClosed) {
  std::uint64_t shared = 0;
  std::atomic<bool> inside{false};
  std::atomic<bool> end{false};
  std::uint64_t bodies = 0;
  std::thread program{[&] {
    std::int64_t now = 0;
    while (!end.load()) {
      if (!begin(slot, ++now)) continue;
      inside.store(true, std::memory_order_relaxed);
      ++shared;
      ++bodies;
      inside.store(false, std::memory_order_relaxed);
      slot.done.store(slot.released.load(), std::memory_order_release);
    }
  }};
  std::uint64_t outs = 0;
  std::uint64_t met = 0;
  std::mt19937 random{1};
  while (outs < kReleases / 10 || slot.begun.load() < kReleases / 10) {
    slot.open.store(1, std::memory_order_seq_cst);
    for (std::uint64_t i = random() % 200; i > 0; --i) static_cast<void>(slot.waiting());
    slot.open.store(0, std::memory_order_seq_cst);
    while (!slot.waiting()) ::sched_yield();
    for (int i = 0; i < 20; ++i) met += inside.load(std::memory_order_relaxed) ? 1 : 0;
    ++shared;
    ++outs;
  }
  end.store(true);
  program.join();
  EXPECT_EQ(met, 0U) << "bodies that ran while the slot was closed";
  EXPECT_EQ(shared, bodies + outs);
  EXPECT_EQ(slot.begun.load(), bodies);
}

/// One thread changes a variable, and a second thread waits on the wake word for this change. No wake-up may
/// be lost.
class WakeWordBetweenTwoThreads : public testing::Test {
 protected:
  void ring(std::uint32_t bits) {
    wake_word.rings.fetch_add(1, std::memory_order_seq_cst);
    os::futex_wake(wake_word.rings, bits);
  }
  WakeWord wake_word{};
};

// As in the product, the gateway first announces that it sleeps, and then checks for a sample once more.
TEST_F(WakeWordBetweenTwoThreads, WakesTheGatewayOnlyIfItSleeps) {
  constexpr std::uint32_t kSamples = kReleases / 2;
  std::atomic<std::uint32_t> published{0};
  std::atomic<std::uint32_t> seen{0};
  std::uint64_t announced = 0;
  std::thread gateway{[&] {
    while (seen.load(std::memory_order_relaxed) < kSamples) {
      const std::uint32_t rings = wake_word.rings.load(std::memory_order_seq_cst);
      ++announced;
      wake_word.gateway_sleeps.store(1, std::memory_order_seq_cst);
      if (published.load(std::memory_order_seq_cst) == seen.load(std::memory_order_relaxed)) {
        os::futex_wait(wake_word.rings, rings, kGatewayBit);
      }
      wake_word.gateway_sleeps.store(0, std::memory_order_seq_cst);
      seen.store(published.load(std::memory_order_seq_cst), std::memory_order_release);
    }
  }};
  std::uint64_t rings = 0;
  bool lost = false;
  for (std::uint32_t i = 1; i <= kSamples && !lost; ++i) {
    published.store(i, std::memory_order_seq_cst);
    wake_word.note(kGatewayBit);
    if (const std::uint32_t bits = wake_word.take_pending(); bits != 0) {
      EXPECT_EQ(bits, kGatewayBit);
      ++rings;
      ring(bits);
    }
    const Instant limit = os::now() + std::chrono::seconds{10};
    while (seen.load(std::memory_order_acquire) != i && !lost) {
      if (i % 3 != 0) ::sched_yield();  // for every third sample, publish while the gateway goes to sleep
      lost = os::now() > limit;
    }
    EXPECT_FALSE(lost) << "the wake-up for sample " << i << " was lost";
  }
  if (lost) {
    published.store(kSamples);
    ring(kGatewayBit);
  }
  gateway.join();
  EXPECT_LE(rings, announced) << "the gateway was woken while it was awake";
  EXPECT_GT(rings, 0U) << "the gateway never slept";
}

// Two writers set the same bit. At the end of its cycle, each writer takes all pending bits, including a bit
// that the other writer set.
TEST_F(WakeWordBetweenTwoThreads, LosesNoBitIfSeveralWritersSetIt) {
  constexpr std::uint32_t kSamples = kReleases / 4;
  constexpr int kWriters = 2;
  const std::uint32_t bit = wake_bit(5);
  std::atomic<std::uint32_t> published{0};
  std::atomic<std::uint32_t> rung{0};
  std::thread waiter{[&] {
    std::uint32_t seen = 0;
    while (seen < kSamples * kWriters) {
      const std::uint32_t rings = wake_word.rings.load(std::memory_order_seq_cst);
      if (published.load(std::memory_order_seq_cst) == seen) {
        const Instant limit = os::now() + std::chrono::seconds{10};
        os::futex_wait(wake_word.rings, rings, bit, limit);
        if (os::now() >= limit) {
          ADD_FAILURE() << "no wake-up for sample " << published.load() << " after " << seen;
          return;
        }
      }
      seen = published.load(std::memory_order_seq_cst);
    }
  }};
  std::vector<std::thread> writers;
  for (int w = 0; w < kWriters; ++w) {
    writers.emplace_back([&] {
      for (std::uint32_t i = 0; i < kSamples; ++i) {
        published.fetch_add(1, std::memory_order_seq_cst);
        wake_word.note(bit);
        const std::uint32_t bits = wake_word.take_pending();
        if (bits == 0) continue;  // the other writer took the bit and wakes the waiting thread
        EXPECT_EQ(bits, bit);
        ++rung;
        ring(bits);
      }
    });
  }
  for (auto& writer : writers) writer.join();
  waiter.join();
  EXPECT_EQ(wake_word.pending.load(), 0U);
  EXPECT_LE(rung.load(), kSamples * kWriters);
}

TEST(WakeWord, IgnoresTheBitOfAGatewayThatIsAwake) {
  WakeWord wake_word{};
  wake_word.note(kGatewayBit);
  EXPECT_EQ(wake_word.take_pending(), 0U);
  wake_word.note(kGatewayBit | wake_bit(2));
  EXPECT_EQ(wake_word.take_pending(), wake_bit(2));
  wake_word.gateway_sleeps.store(1);
  wake_word.note(kGatewayBit);
  wake_word.note(kSporadicBit);
  EXPECT_EQ(wake_word.take_pending(), kGatewayBit | kSporadicBit);
  EXPECT_EQ(wake_word.take_pending(), 0U) << "the bits were taken";
}

TEST(WakeBit, OfAProgramIsNeverAReservedBit) {
  for (std::size_t slot = 0; slot < 1000; ++slot) {
    EXPECT_EQ(wake_bit(slot) & (kSporadicBit | kGatewayBit), 0U);
    EXPECT_NE(wake_bit(slot), 0U);
  }
}

}  // namespace
}  // namespace takt::channel::release_slot_test
