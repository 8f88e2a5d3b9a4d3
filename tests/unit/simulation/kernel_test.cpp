#include "kernel.hpp"

#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace takt::simulation::kernel_test {
namespace {

using testing::ElementsAre;

constexpr Instant kBegin = from_ns(1000);
constexpr Nanoseconds kTen{10};

/// What happened, with the time since the begin.
class Said {
 public:
  explicit Said(Kernel& kernel) : kernel_(kernel) {}
  void operator()(const std::string& what) {
    said.push_back(what + " " + std::to_string((kernel_.now() - kBegin).count()));
  }
  std::vector<std::string> said;

 private:
  Kernel& kernel_;
};

TEST(Kernel, ComesBackAtTheEndWhereNothingHappens) {
  Kernel kernel{kBegin};
  kernel.run_until(kBegin + kTen);
  EXPECT_EQ(kBegin + kTen, kernel.now());
}

TEST(Kernel, StrandsWithProcessorsOfTheirOwnWorkAtTheSameTime) {
  Kernel kernel{kBegin};
  Said say{kernel};
  kernel.spawn({}, [&] {
    kernel.work(kTen);
    say("a");
  });
  kernel.spawn({}, [&] {
    kernel.work(kTen);
    say("b");
  });
  kernel.run_until(kBegin + 3 * kTen);
  EXPECT_THAT(say.said, ElementsAre("a 10", "b 10"));
}

TEST(Kernel, OnOneProcessorTheHigherPriorityGoesFirstAndTheOtherIsStretched) {
  Kernel kernel{kBegin};
  Said say{kernel};
  Processor one;
  kernel.spawn({.processor = &one, .priority = 1}, [&] {
    say("low");
    kernel.work(kTen);
    say("low");
  });
  kernel.spawn({.processor = &one, .priority = 2}, [&] {
    kernel.sleep_until(kBegin + Nanoseconds{4});
    say("high");
    kernel.work(Nanoseconds{3});
    say("high");
  });
  kernel.run_until(kBegin + 3 * kTen);
  EXPECT_THAT(say.said, ElementsAre("low 0", "high 4", "high 7", "low 13"));
}

TEST(Kernel, AmongEqualsWhoCameFirstIsNotPreempted) {
  Kernel kernel{kBegin};
  Said say{kernel};
  Processor one;
  kernel.spawn({.processor = &one, .priority = 1}, [&] {
    kernel.work(kTen);
    say("first");
    kernel.work(kTen);
    say("first");
  });
  kernel.spawn({.processor = &one, .priority = 1}, [&] {
    say("second");
    kernel.work(kTen);
    say("second");
  });
  kernel.run_until(kBegin + 10 * kTen);
  EXPECT_THAT(say.said, ElementsAre("first 10", "first 20", "second 20", "second 30"));
}

TEST(Kernel, WhoIsWokenWhileAnotherOfAHigherPriorityWorksWaitsForTheProcessor) {
  Kernel kernel{kBegin};
  Said say{kernel};
  Processor one;
  kernel.spawn({.processor = &one, .priority = 2}, [&] { kernel.work(kTen); });
  kernel.spawn({.processor = &one, .priority = 1}, [&] { say("low"); });
  kernel.run_until(kBegin + 3 * kTen);
  EXPECT_THAT(say.said, ElementsAre("low 10"));
}

TEST(Kernel, AWaitEndsWhenItIsWokenOrWhenItsTimeHasCome) {
  Kernel kernel{kBegin};
  Said say{kernel};
  Strand& sleeper = kernel.spawn({}, [&] {
    say(kernel.wait(kBegin + kTen) ? "woken" : "not woken");
    say(kernel.wait(kBegin + 2 * kTen) ? "woken" : "not woken");
    kernel.sleep_until(kBegin + 3 * kTen);
    say("slept");
  });
  kernel.at(kBegin + Nanoseconds{5}, [&] {
    kernel.wake(sleeper, Nanoseconds{1});
    kernel.wake(sleeper, Nanoseconds{2});  // once is enough
  });
  kernel.run_until(kBegin + 10 * kTen);
  EXPECT_THAT(say.said, ElementsAre("woken 6", "not woken 20", "slept 30"));
}

TEST(Kernel, OfTwoThingsAtOneInstantTheFirstCausedComesFirst) {
  Kernel kernel{kBegin};
  Said say{kernel};
  kernel.at(kBegin + kTen, [&] { say("call"); });
  kernel.spawn({}, [&] {
    kernel.sleep_until(kBegin + kTen);
    say("strand");
  });
  kernel.run_until(kBegin + kTen);
  EXPECT_THAT(say.said, ElementsAre("call 10", "strand 10"));
}

TEST(Kernel, WhoIsKilledNeverGoesOnAndLeavesItsProcessor) {
  Kernel kernel{kBegin};
  Said say{kernel};
  Processor one;
  Strand& dies = kernel.spawn({.processor = &one, .priority = 2}, [&] {
    kernel.work(10 * kTen);
    say("never");
  });
  kernel.spawn({.processor = &one, .priority = 1}, [&] { say("free"); });
  kernel.spawn({}, [&] {
    kernel.sleep_until(kBegin + kTen);
    kernel.kill(dies);
    say("killed");
    kernel.end();
  });
  kernel.run_until(kBegin + 20 * kTen);
  EXPECT_THAT(say.said, ElementsAre("killed 10", "free 10"));
  EXPECT_TRUE(dies.ended());
}

TEST(Kernel, NothingBehindTheEndHappensBeforeItIsTime) {
  Kernel kernel{kBegin};
  Said say{kernel};
  kernel.spawn({}, [&] {
    kernel.work(2 * kTen);
    say("done");
  });
  kernel.run_until(kBegin + kTen);
  EXPECT_THAT(say.said, ElementsAre());
  kernel.run_until(kBegin + 2 * kTen);
  EXPECT_THAT(say.said, ElementsAre("done 20"));
}

}  // namespace
}  // namespace takt::simulation::kernel_test
