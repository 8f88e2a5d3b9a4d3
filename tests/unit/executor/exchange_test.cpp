#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "fake_device.hpp"

namespace takt::executor::exchange_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using State = Exchange::State;

/// A body that continues the count of the body that it replaces, and records the number of each release that
/// it served.
class Counting final : public Body {
 public:
  explicit Counting(VirtualClock& clock) : clock_(clock) {}
  Outcome run(const Cycle& cycle) noexcept override {
    clock_.time += takes;
    if (fails_at && cycle.number >= *fails_at) return "it cannot do this one";
    ++count;
    served.push_back(cycle.number);
    Outcome outcome;
    outcome.finished = cycle.number == finishes_at;
    return outcome;
  }
  Outcome condition(const Cycle&, bool*) noexcept override { return {}; }
  bool take_over(Body& before) noexcept override {
    if (refuses > 0) {
      --refuses;
      return false;
    }
    if (comes) count = static_cast<Counting&>(before).count;
    comes = false;
    ++taken_over;
    return true;
  }

  std::uint64_t count = 0;
  std::vector<std::uint64_t> served;
  std::optional<std::uint64_t> fails_at;
  std::optional<std::uint64_t> finishes_at;
  Nanoseconds takes{};
  int refuses = 0;
  int taken_over = 0;
  bool comes = true;  ///< true until this body has taken over the count of another body

 private:
  VirtualClock& clock_;
};

/// A device with two modules, whose periods are 1 ms and 2 ms. The tests exchange the body of the second
/// module.
class BodyExchange : public testing::Test {
 protected:
  explicit BodyExchange(model::Module module = thread(milliseconds{2}, 2))
      : device({thread(milliseconds{1}, 1), std::move(module)}) {
    old.comes = false;
    device.periodic_units[1].body = &old;
    device.make_executor();
    device.join();
  }
  State state() const { return exchange.state.load(); }
  void cycles(int n) {
    for (int i = 0; i < n; ++i) device.cycle();
  }
  /// Expects that, in the first `rows` rows, each release of the second module was served exactly once, by
  /// one of these bodies.
  void expect_all_served(std::uint64_t rows, const std::vector<const Counting*>& bodies) const {
    std::vector<int> times((rows + 1) / 2);
    for (const Counting* body : bodies)
      for (const std::uint64_t number : body->served) ++times.at(number);
    for (std::size_t n = 0; n < times.size(); ++n) EXPECT_EQ(times[n], 1) << "release " << n;
    EXPECT_EQ(device.blocks[1].cycles.load(), times.size());
    EXPECT_EQ(device.blocks[1].missed.load(), 0U);
    EXPECT_EQ(device.blocks[1].errors.load(), 0U);
    EXPECT_EQ(device.blocks[1].in_tables.load(), 1U);
  }

  FakeDevice device;
  Counting old{device.clock};
  Counting next{device.clock};
  Exchange exchange{.index = 1, .body = &next, .runs = 3};
};

TEST_F(BodyExchange, HappensBetweenTwoRowsWithoutAMissedRelease) {
  cycles(5);
  device.executor->exchange(exchange);
  EXPECT_EQ(state(), State::waiting);
  cycles(1);
  EXPECT_EQ(state(), State::on_trial);
  EXPECT_EQ(exchange.row, 5U);
  EXPECT_EQ(device.blocks[1].on_trial.load(), 1U);
  cycles(5);
  EXPECT_EQ(state(), State::on_trial) << "its third run was in the last of these rows";
  cycles(1);
  EXPECT_EQ(state(), State::kept);
  EXPECT_EQ(device.blocks[1].on_trial.load(), 0U);
  expect_all_served(12, {&old, &next});
  EXPECT_EQ(next.count, 6U);
  EXPECT_EQ(old.taken_over, 0);
}

TEST_F(BodyExchange, RestoresTheOldBodyIfTheNewOneFailsDuringItsTrial) {
  cycles(4);
  next.fails_at = 3;
  device.executor->exchange(exchange);
  cycles(4);
  EXPECT_EQ(state(), State::put_back);
  EXPECT_EQ(exchange.error, ErrorType::failure);
  EXPECT_EQ(exchange.cycle, 3U);
  EXPECT_EQ(exchange.text.view(), "it cannot do this one");
  EXPECT_EQ(device.blocks[1].on_trial.load(), 0U);
  EXPECT_EQ(device.blocks[1].error.load(), 0U) << "no error is raised: the module continues";
  cycles(2);
  expect_all_served(10, {&old, &next});
  EXPECT_EQ(next.served, std::vector<std::uint64_t>{2});
  EXPECT_EQ(old.count, 4U) << "its own state, without the other body's runs";
  EXPECT_EQ(old.taken_over, 1);
}

TEST_F(BodyExchange, CallsErrorIfTheNewBodyFailsAfterItsTrial) {
  next.fails_at = 3;
  device.executor->exchange(exchange);
  cycles(7);
  EXPECT_EQ(state(), State::kept);
  EXPECT_EQ(device.blocks[1].in_tables.load(), 0U);
  EXPECT_EQ(device.blocks[1].error.load(), static_cast<std::uint32_t>(ErrorType::failure));
  EXPECT_TRUE(old.served.empty());
}

TEST_F(BodyExchange, KeepsANewBodyThatFinishesDuringItsTrial) {
  next.finishes_at = 1;
  device.executor->exchange(exchange);
  cycles(7);
  EXPECT_EQ(state(), State::kept);
  EXPECT_EQ(device.blocks[1].in_tables.load(), 0U);
  EXPECT_EQ(device.blocks[1].finished.load(), 1U);
  EXPECT_EQ(device.blocks[1].errors.load(), 0U);
  EXPECT_EQ(next.served, (std::vector<std::uint64_t>{0, 1}));
  EXPECT_TRUE(old.served.empty());
}

TEST_F(BodyExchange, DoesNotHappenAfterItsModuleHasFinished) {
  old.finishes_at = 1;
  cycles(7);
  device.executor->exchange(exchange);
  cycles(4);
  EXPECT_EQ(state(), State::waiting);
  EXPECT_EQ(old.served, (std::vector<std::uint64_t>{0, 1}));
  EXPECT_EQ(device.blocks[1].cycles.load(), 2U);
  EXPECT_EQ(device.blocks[1].missed.load(), 0U);
  EXPECT_EQ(device.blocks[1].finished.load(), 1U);
}

TEST_F(BodyExchange, CanBeWithdrawnWhileItsModuleIsOutOfTheTables) {
  device.blocks[1].in_tables.store(0);
  device.executor->exchange(exchange);
  cycles(4);
  EXPECT_EQ(state(), State::waiting);
  EXPECT_TRUE(device.executor->withdraw());
  device.blocks[1].in_tables.store(1);
  cycles(4);
  EXPECT_EQ(state(), State::waiting);
  EXPECT_EQ(old.count, 2U);
  device.executor->exchange(exchange);
  cycles(1);
  EXPECT_FALSE(device.executor->withdraw()) << "a row has already begun the exchange";
  EXPECT_EQ(state(), State::on_trial);
}

TEST_F(BodyExchange, KeepsTheOldBodyIfTheNewOneDeclinesToTakeOver) {
  next.refuses = 1;
  device.executor->exchange(exchange);
  cycles(3);
  EXPECT_EQ(state(), State::not_now);
  device.executor->exchange(exchange);
  cycles(3);
  EXPECT_EQ(state(), State::on_trial);
  expect_all_served(6, {&old, &next});
}

TEST_F(BodyExchange, IgnoresAModuleOfAnotherExecutor) {
  exchange.index = 7;  // the executor has no module 7
  device.executor->exchange(exchange);
  cycles(10);
  EXPECT_EQ(state(), State::waiting);
  expect_all_served(10, {&old});
}

// Exchanges bodies at random moments; some of the new bodies fail. Each release must be served exactly once,
// and the count must continue from body to body.
TEST_F(BodyExchange, LosesNoReleaseOverThousandsOfExchanges) {
  std::mt19937 random{1};
  std::vector<std::unique_ptr<Counting>> bodies;
  std::vector<std::unique_ptr<Exchange>> exchanges;
  std::vector<const Counting*> all{&old};
  Counting* runs = &old;
  std::uint64_t rows = 0;
  int kept = 0;
  int back = 0;
  for (int n = 0; n < 5000; ++n) {
    bodies.push_back(std::make_unique<Counting>(device.clock));
    Counting& body = *bodies.back();
    all.push_back(&body);
    exchanges.push_back(std::make_unique<Exchange>());
    Exchange& one = *exchanges.back();
    one.index = 1;
    one.body = &body;
    one.runs = 1 + random() % 4;
    const bool fails = random() % 3 == 0;
    const std::uint64_t served = device.blocks[1].cycles.load();
    if (fails) body.fails_at = served + random() % one.runs;
    const std::uint64_t count = runs->count;
    device.executor->exchange(one);
    while (one.state != State::kept && one.state != State::put_back) {
      device.cycle();
      ASSERT_LT(++rows, 1'000'000U);
    }
    ASSERT_EQ(one.state == State::put_back, fails);
    if (fails) {
      ASSERT_EQ(runs->count, count + 1) << "it served the release in which the new body failed";
      ++back;
    } else {
      ASSERT_GE(body.count, count + one.runs);
      body.comes = false;
      runs = &body;
      ++kept;
    }
    for (auto i = random() % 5; i > 0; --i, ++rows) device.cycle();
  }
  EXPECT_GT(kept, 1000);
  EXPECT_GT(back, 1000);
  expect_all_served(rows, all);
  EXPECT_EQ(device.blocks[0].cycles.load(), rows);
  EXPECT_EQ(device.block->missed.load(), 0U);
}

class BodyExchangeWithLimits : public BodyExchange {
 protected:
  BodyExchangeWithLimits() : BodyExchange(module()) {}
  static model::Module module() {
    model::Module module = thread(milliseconds{2}, 2);
    module.budget = microseconds{100};
    module.overrun.emplace();
    module.overrun->what = model::Overrun::error;
    return module;
  }
};

TEST_F(BodyExchangeWithLimits, RestoresTheOldBodyIfTheNewOneExceedsItsBudget) {
  next.takes = microseconds{200};
  device.executor->exchange(exchange);
  cycles(6);
  EXPECT_EQ(state(), State::put_back);
  EXPECT_EQ(exchange.error, ErrorType::budget);
  expect_all_served(6, {&old, &next});
  EXPECT_EQ(next.served.size(), 1U);
}

TEST_F(BodyExchangeWithLimits, RestoresTheOldBodyIfTheNewOneOverruns) {
  next.takes = milliseconds{3};
  device.executor->exchange(exchange);
  cycles(1);
  EXPECT_EQ(state(), State::put_back);
  EXPECT_EQ(exchange.error, ErrorType::overrun);
  EXPECT_EQ(device.blocks[1].error.load(), static_cast<std::uint32_t>(ErrorType::overrun));
  EXPECT_EQ(device.blocks[1].in_tables.load(), 0U);
  cycles(1);  // no body serves the release that is due in this row
  device.blocks[1].error.store(0);
  device.blocks[1].in_tables.store(1);  // the node sets this flag after a recovery
  cycles(4);
  EXPECT_EQ(next.served.size(), 1U);
  EXPECT_EQ(device.blocks[1].in_tables.load(), 1U);
}

}  // namespace
}  // namespace takt::executor::exchange_test
