// The seat between two real processes. What they find is summed in shared memory by the program and by the
// scheduler alone, and compared.
#include <takt/channel/seat.hpp>

#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <utility>

#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::channel {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::uint32_t kReleases = 20'000;
#else
constexpr std::uint32_t kReleases = 200'000;
#endif

struct Shared {
  Seat seat;
  Bell bell;
  std::atomic<std::uint64_t> served;
  std::atomic<std::uint64_t> sum;    // of the cycles it was released for
  std::atomic<std::uint64_t> wrong;  // releases that came doubled, or with the instant of another
  std::atomic<std::uint64_t> sleeps;
};

/// A program as libtakt_process makes it, in a process of its own. It looks at the seat `patience` times
/// before it sleeps.
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
    Seat& seat = shared.seat;
    std::uint32_t taken = 0;
    while (true) {
      seat.done.store(taken, std::memory_order_release);
      if (taken == 0) seat.phase.store(SeatPhase::ready, std::memory_order_release);
      for (int i = 0; i < patience && seat.released.load(std::memory_order_acquire) == taken; ++i) {
      }
      while (seat.released.load(std::memory_order_acquire) == taken) {
        if (seat.end.load(std::memory_order_acquire) != 0) return;
        const std::uint32_t rings = shared.bell.rings.load();
        seat.sleeping.store(1);
        if (seat.released.load() == taken && seat.end.load() == 0) {
          ++shared.sleeps;
          os::futex_wait(shared.bell.rings, rings, seat.bell_bit);
        }
        seat.sleeping.store(0);
      }
      const std::uint32_t now = seat.released.load(std::memory_order_acquire);
      const std::uint64_t cycle = seat.cycle.load(std::memory_order_relaxed);
      if (now != taken + 1) ++shared.wrong;
      if (seat.release_ns.load(std::memory_order_relaxed) != static_cast<std::int64_t>(cycle) * 1000)
        ++shared.wrong;
      taken = now;
      ++shared.served;
      shared.sum += cycle;
      while (stays_in_body) ::sched_yield();
    }
  }

  int pid_ = 0;
};

class SeatOfTwoProcesses : public testing::Test {
 protected:
  SeatOfTwoProcesses()
      : memory(std::move(os::SharedMemory::create("seat", sizeof(Shared)).value())),
        shared(*reinterpret_cast<Shared*>(memory.data())) {
    shared.seat.bell_bit = bell_bit(3);
  }

  void ring(std::uint32_t bits) {
    shared.bell.rings.fetch_add(1);
    os::futex_wake(shared.bell.rings, bits);
  }
  /// False when it did not become so in ten seconds: a release was lost.
  template <class Predicate>
  bool until(const Predicate& holds) {
    const Instant limit = os::now() + std::chrono::seconds{10};
    while (!holds()) {
      if (os::now() > limit) return false;
      ::sched_yield();
    }
    return true;
  }
  /// Releases `n` times, each as soon as the program waits; each attempt is a cycle.
  void release_times(std::uint32_t n) {
    for (std::uint32_t given = 0; given < n;) {
      const Release outcome = release(shared.seat, cycle, static_cast<std::int64_t>(cycle) * 1000);
      if (outcome == Release::busy) {
        ASSERT_TRUE(until([&] { return shared.seat.waiting(); })) << "release " << given << " was lost";
      } else {
        ++given;
        expected += cycle;
        if (outcome == Release::wake) ring(shared.seat.bell_bit);
      }
      ++cycle;
    }
    ASSERT_TRUE(until([&] { return shared.seat.waiting(); }));
  }
  void end(Program& program) {
    shared.seat.end.store(1);
    ring(~0U);
    EXPECT_EQ(program.wait(), 0);
  }

  os::SharedMemory memory;
  Shared& shared;
  std::uint64_t cycle = 0;
  std::uint64_t expected = 0;
};

TEST_F(SeatOfTwoProcesses, LosesAndDoublesNothing) {
  Program program{shared, 200};
  release_times(kReleases);
  end(program);
  EXPECT_EQ(shared.served.load(), kReleases);
  EXPECT_EQ(shared.sum.load(), expected);
  EXPECT_EQ(shared.wrong.load(), 0U);
}

TEST_F(SeatOfTwoProcesses, LosesNothingWhenTheProgramAlwaysSleeps) {
  Program program{shared, 0};
  release_times(kReleases);
  end(program);
  EXPECT_EQ(shared.served.load(), kReleases);
  EXPECT_EQ(shared.sum.load(), expected);
  EXPECT_EQ(shared.wrong.load(), 0U);
  EXPECT_GT(shared.sleeps.load(), 0U);
}

TEST_F(SeatOfTwoProcesses, IsUsableAfterTheProgramWasKilled) {
  for (const bool in_body : {true, false}) {
    clear_for_new_program(shared.seat);
    Program first{shared, 0, in_body};
    ASSERT_TRUE(until([&] { return shared.seat.waiting(); }));
    if (in_body) {
      const std::uint64_t before = shared.served.load();
      if (release(shared.seat, 0, 0) == Release::wake) ring(shared.seat.bell_bit);
      ASSERT_TRUE(until([&] { return shared.served.load() == before + 1; }));
    } else {
      ASSERT_TRUE(until([&] { return shared.seat.sleeping.load() != 0; }));
    }
    first.kill();
    if (in_body) {
      EXPECT_EQ(release(shared.seat, 1, 1000), Release::busy);
    }

    clear_for_new_program(shared.seat);
    EXPECT_EQ(release(shared.seat, 1, 1000), Release::busy) << "nobody is there";
    EXPECT_EQ(shared.seat.sleeping.load(), 0U);
    Program second{shared, 10};
    ASSERT_TRUE(until([&] { return shared.seat.waiting(); }));
    const std::uint64_t before = shared.served.load();
    release_times(100);
    EXPECT_EQ(shared.served.load(), before + 100);
    EXPECT_EQ(shared.wrong.load(), 0U);
    end(second);
  }
}

TEST(Seat, NoProgramIsBusy) {
  Seat seat{};
  EXPECT_EQ(release(seat, 0, 0), Release::busy);
  EXPECT_EQ(seat.released.load(), 0U);
}

TEST(Seat, CountsOnAfterTheNumberOfReleasesHasWrapped) {
  Seat seat{};
  seat.phase.store(SeatPhase::ready);
  seat.released.store(~0U);
  seat.done.store(~0U);
  EXPECT_EQ(release(seat, 1, 1), Release::given);
  EXPECT_EQ(seat.released.load(), 0U);
  EXPECT_EQ(release(seat, 2, 2), Release::busy);
  seat.done.store(0);
  EXPECT_EQ(release(seat, 2, 2), Release::given);
}

TEST(BellBit, OfAProgramIsNeverThatOfTheSporadicThreads) {
  for (std::size_t seat = 0; seat < 1000; ++seat) {
    EXPECT_EQ(bell_bit(seat) & kSporadicBit, 0U);
    EXPECT_NE(bell_bit(seat), 0U);
  }
}

}  // namespace
}  // namespace takt::channel
