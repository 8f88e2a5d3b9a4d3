// A sound course, and what is said of one that is not: each test spoils one thing.
#include "invariants.hpp"

#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace takt::simulation::invariants_test {
namespace {

using lifecycle::State;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr Instant kStart = from_ns(1'000'000'000);
constexpr std::uint32_t kFast = 0;      // each row, second in it
constexpr std::uint32_t kSlow = 1;      // each second row, first in it
constexpr std::uint32_t kProgram = 2;   // each row, last in it
constexpr std::uint32_t kSporadic = 3;  // 5 ms
constexpr std::uint32_t kUrgent = 4;    // sporadic, 1 ms

void connect(model::Cell& cell, model::Endpoint from, model::Endpoint to) {
  model::Connection connection;
  connection.from = std::move(from);
  connection.to = std::move(to);
  cell.connections.push_back(connection);
}

model::Cell make_cell() {
  model::Cell cell;
  cell.name = "c";
  model::Device device;
  device.name = "d";
  device.executors.emplace_back();
  const auto add = [&device](const char* name, int priority, auto&& shape) {
    model::Module module;
    module.name = name;
    module.executor = "main";
    module.priority = priority;
    shape(module);
    device.modules.push_back(module);
  };
  add("fast", 2, [](auto& m) { m.period = milliseconds{1}; });
  add("slow", 1, [](auto& m) { m.period = milliseconds{2}; });
  add("program", 3, [](auto& m) {
    m.period = milliseconds{1};
    m.type = model::ModuleType::process;
  });
  for (const char* name : {"sporadic", "urgent"}) {
    add(name, 1, [name](auto& m) {
      m.operation = model::Operation::sporadic;
      m.deadline = milliseconds{name[0] == 's' ? 5 : 1};
      m.interarrival = milliseconds{2};
    });
  }
  cell.devices.push_back(device);
  connect(cell, {"d", "fast", "out"}, {"d", "slow", "in"});
  return cell;
}

class InvariantsTest : public testing::Test {
 protected:
  static Instant at(Nanoseconds since) { return kStart + since; }
  void hear(Event event, Nanoseconds since = now_) {
    event.at = at(since);
    event.device = 0;
    if (event.connection != Event::kNone) event.device = Event::kNone;
    checker.hear(event);
  }
  void step(std::uint32_t module, lifecycle::Event event, State from, State to, std::uint64_t sequence) {
    hear({.what = What::step,
          .module = module,
          .step = {.from = from, .to = to, .event = event, .sequence = sequence}});
  }
  void begin(std::uint32_t module) {
    using lifecycle::Event;
    step(module, Event::initialize, State::idle, State::initialize, 1);
    step(module, Event::start, State::initialize, State::start, 2);
    hear({.what = What::put_in, .module = module});
  }
  void begin() {
    for (std::uint32_t m = 0; m < cell.devices[0].modules.size(); ++m) begin(m);
    hear({.what = What::joined, .executor = 0, .number = 0, .release = kStart}, -milliseconds{1});
  }
  static Nanoseconds due(std::uint64_t row) { return milliseconds{1} * static_cast<std::int64_t>(row); }
  void wake(std::uint64_t row, Nanoseconds late = microseconds{1}) {
    now_ = due(row) + late;
    hear({.what = What::woke, .executor = 0, .number = row, .release = at(due(row))});
  }
  void run(std::uint32_t module, std::uint64_t number, Nanoseconds release,
           ErrorType error = ErrorType::none) {
    hear({.what = What::run, .module = module, .number = number, .release = at(release)});
    now_ += microseconds{10};
    hear({.what = What::ran, .module = module, .number = number, .error = error});
  }
  void release(std::uint64_t number, Nanoseconds of) {
    hear({.what = What::released, .module = kProgram, .number = number, .release = at(of)});
  }
  void walked(std::uint64_t row, std::uint64_t missed = 0) {
    hear({.what = What::walked, .executor = 0, .number = row, .count = missed, .release = at(due(row))});
  }
  void row(std::uint64_t n) {
    wake(n);
    if (n % 2 == 0) run(kSlow, n / 2, due(n));
    run(kFast, n, due(n));
    release(n, due(n));
    walked(n);
  }
  const std::vector<std::string>& said() const { return checker.violations(); }

  static inline Nanoseconds now_{};
  model::Cell cell = make_cell();
  std::vector<schedule::DevicePlan> plans = *schedule::plan(cell);
  Invariants checker{cell, plans, kStart};
};

Totals::OfModule counted(std::uint64_t cycles, std::uint64_t missed = 0) {
  return {.cycles = cycles, .missed = missed, .state = State::start, .steps = 2};
}

TEST_F(InvariantsTest, ASoundCourseIsSound) {
  begin();
  for (std::uint64_t n = 0; n < 4; ++n) row(n);
  checker.close(0, {.executors = {{.cycles = 4, .missed = 0, .next_row = 4}},
                    .modules = {counted(4), counted(2), counted(4), counted(0), counted(0)}});
  EXPECT_THAT(said(), IsEmpty());
}

TEST_F(InvariantsTest, RowsThatWereMissedAreCounted) {
  begin();
  row(0);
  wake(1, milliseconds{2});  // in the slot of row 3
  run(kFast, 3, due(3));
  release(3, due(3));
  walked(3, 2);
  checker.close(0, {.executors = {{.cycles = 2, .missed = 2, .next_row = 4}},
                    .modules = {counted(2, 2), counted(1, 1), counted(2, 2), counted(0), counted(0)}});
  EXPECT_THAT(said(), IsEmpty());
}

TEST_F(InvariantsTest, ARowIsOnTheGrid) {
  begin();
  row(0);
  hear({.what = What::woke, .executor = 0, .number = 1, .release = at(due(1) + Nanoseconds{1})},
       due(1) + microseconds{2});
  EXPECT_THAT(said(), ElementsAre(HasSubstr("the grid is left")));
}

TEST_F(InvariantsTest, ARowRunsInItsSlot) {
  begin();
  wake(0, milliseconds{1});
  run(kSlow, 0, due(0));
  run(kFast, 0, due(0));
  release(0, due(0));
  walked(0);
  EXPECT_THAT(said(), ElementsAre(HasSubstr("in the slot of another row")));
}

TEST_F(InvariantsTest, ARowIsNotWalkedEarlyOrTwiceOrLost) {
  begin();
  wake(0, -microseconds{1});
  EXPECT_THAT(said(), Contains(HasSubstr("woke too early")));
  walked(0);
  row(0);
  EXPECT_THAT(said(), Contains(HasSubstr("its next row was 1")));
  row(2);
  EXPECT_THAT(said(),
              Contains(HasSubstr("d executor main woke 1000 ns after its release: its next row was 1")));
  wake(3);
  walked(4);
  EXPECT_THAT(said(), Contains(HasSubstr("rows are lost")));
}

TEST_F(InvariantsTest, ARowHasTheOrderOfItsTable) {
  begin();
  wake(0);
  run(kFast, 0, due(0));
  run(kSlow, 0, due(0));
  release(0, due(0));
  walked(0);
  EXPECT_THAT(said(), Contains(HasSubstr("out of turn")));
}

TEST_F(InvariantsTest, ARowServesAllThatAreInTheTables) {
  begin();
  wake(0);
  run(kSlow, 0, due(0));
  run(kFast, 0, due(0));
  walked(0);
  EXPECT_THAT(said(), ElementsAre(HasSubstr("program was not served in its turn")));
}

TEST_F(InvariantsTest, ARowServesNobodyTwiceOrWhoIsNotDue) {
  begin();
  wake(0);
  run(kSlow, 0, due(0));
  run(kFast, 0, due(0));
  release(0, due(0));
  release(0, due(0));
  walked(0);
  EXPECT_THAT(said(), ElementsAre(HasSubstr("program was served out of turn")));
  wake(1);
  run(kSlow, 0, due(1));
  walked(1);
  EXPECT_THAT(said(), Contains(HasSubstr("slow was served out of turn")));
}

TEST_F(InvariantsTest, AModuleIsToldItsRelease) {
  begin();
  wake(0);
  run(kSlow, 0, due(0));
  run(kFast, 1, due(0));
  release(0, due(1));
  walked(0);
  EXPECT_THAT(said(), ElementsAre(HasSubstr("fast was told another release"),
                                  HasSubstr("program was told another release")));
}

TEST_F(InvariantsTest, WhoIsNotInTheTablesIsNotServed) {
  begin();
  hear({.what = What::taken_out, .module = kProgram});
  hear({.what = What::taken_out, .module = kSlow});
  row(0);
  EXPECT_THAT(said(), ElementsAre(HasSubstr("d.slow run 0 of +0.000000000: it is not in the tables"),
                                  HasSubstr("slow was served and is not in the tables"),
                                  HasSubstr("program was served and is not in the tables")));
}

TEST_F(InvariantsTest, WhoFailedIsTakenOutAndItsSupervisorTakesTheStep) {
  begin();
  wake(0);
  run(kSlow, 0, due(0));
  run(kFast, 0, due(0), ErrorType::failure);
  release(0, due(0));
  walked(0);
  row(1);
  EXPECT_THAT(
      said(),
      ElementsAre(HasSubstr("d.fast run 1 of +0.001000000: it has failed and was left in the tables")));
}

TEST_F(InvariantsTest, AnErrorIsNotForgotten) {
  begin();
  hear({.what = What::taken_out, .module = kFast, .error = ErrorType::budget});
  hear({.what = What::put_in, .module = kFast});
  EXPECT_THAT(said(), ElementsAre(HasSubstr("its error was forgotten")));
}

TEST_F(InvariantsTest, StepsAreThoseOfTheTableAndNoneIsLost) {
  using lifecycle::Event;
  begin();
  step(kFast, Event::initialize, State::start, State::executing, 3);
  EXPECT_THAT(said(), ElementsAre(HasSubstr("the lifecycle's table has no such step")));
  step(kFast, Event::stop, State::executing, State::start, 5);
  EXPECT_THAT(said(), Contains(HasSubstr("step 4 is lost")));
  step(kSlow, Event::stop, State::executing, State::start, 3);
  EXPECT_THAT(said(), Contains(HasSubstr("its state was START")));
}

TEST_F(InvariantsTest, WhoLeavesExecutingIsOutOfTheTables) {
  begin();
  step(kFast, lifecycle::Event::error, State::start, State::recover, 3);
  EXPECT_THAT(said(), ElementsAre(HasSubstr("it is in the tables")));
}

TEST_F(InvariantsTest, ASporadicModuleRunsOnceForEachTimeThatItWasReady) {
  begin();
  hear({.what = What::ready, .module = kSporadic, .release = kStart, .until = at(milliseconds{5})});
  run(kSporadic, 0, {});
  EXPECT_THAT(said(), IsEmpty());
  run(kSporadic, 0, {});
  EXPECT_THAT(said(), ElementsAre(HasSubstr("it was not ready")));
}

TEST_F(InvariantsTest, AmongSporadicModulesTheEarliestDeadlineGoesFirst) {
  begin();
  hear({.what = What::ready, .module = kSporadic, .release = kStart, .until = at(milliseconds{5})});
  hear({.what = What::ready, .module = kUrgent, .release = kStart, .until = at(milliseconds{1})});
  run(kSporadic, 0, {});
  EXPECT_THAT(said(), ElementsAre(HasSubstr("urgent has an earlier deadline")));
}

TEST_F(InvariantsTest, ASporadicModuleKeepsItsInterarrivalTimeAndIsNotAskedAgainBeforeItRan) {
  begin();
  hear({.what = What::ready, .module = kUrgent, .release = kStart, .until = at(milliseconds{1})});
  hear(
      {.what = What::ready, .module = kUrgent, .release = at(milliseconds{1}), .until = at(milliseconds{2})});
  EXPECT_THAT(said(),
              ElementsAre(HasSubstr("asked before it had run"), HasSubstr("sooner than its interarrival")));
  hear({.what = What::ready, .module = kSporadic, .release = kStart, .until = at(milliseconds{4})});
  EXPECT_THAT(said(), Contains(HasSubstr("not its deadline")));
}

TEST_F(InvariantsTest, OneModuleOfAThreadRunsAtATime) {
  begin();
  wake(0);
  hear({.what = What::run, .module = kSlow, .number = 0, .release = kStart});
  hear({.what = What::run, .module = kFast, .number = 0, .release = kStart});
  EXPECT_THAT(said(), ElementsAre(HasSubstr("another module of the row is running")));
  hear({.what = What::ran, .module = kSlow});
  EXPECT_THAT(said(), Contains(HasSubstr("it was not running")));
}

TEST_F(InvariantsTest, SamplesAreReadWholeInOrderAndOnce) {
  const auto sample = [this](What what, std::uint64_t number, std::uint64_t torn = 0) {
    hear({.what = what, .connection = 0, .number = number, .count = torn});
  };
  sample(What::wrote, 1);
  sample(What::wrote, 2);
  sample(What::read, 2);
  EXPECT_THAT(said(), IsEmpty());
  sample(What::read, 2);
  sample(What::read, 1);
  sample(What::read, 3);
  sample(What::read, 4, 1);
  sample(What::wrote, 4);
  sample(What::arrived, 2);
  sample(What::arrived, 2);
  sample(What::arrived, 5);
  EXPECT_THAT(said(),
              ElementsAre(HasSubstr("2 was read before"), HasSubstr("2 was read before"),
                          HasSubstr("not written yet"), HasSubstr("bytes are not those of one sample"),
                          HasSubstr("the number after 2 is left out"), HasSubstr("after 2"),
                          HasSubstr("not written yet")));
}

TEST_F(InvariantsTest, CountersAddUpToWhatHappened) {
  begin();
  row(0);
  Totals totals{.executors = {{.cycles = 2, .missed = 0, .next_row = 1}},
                .modules = {counted(2), counted(1, 1), counted(1), counted(0), counted(0)},
                .unbalanced = {0}};
  totals.modules[kProgram].overruns = 1;
  totals.modules[kSporadic].steps = 3;
  totals.modules[kUrgent].state = State::executing;
  checker.close(0, totals);
  EXPECT_THAT(
      said(),
      ElementsAre("d executor main counted 2 rows of 1",
                  "d executor main counted 2 rows, walked or missed, of 1", "d.fast counted 2 releases of 1",
                  "d.fast counted 2 releases, with those missed, busy or not in the tables, of 1",
                  "d.slow counted 1 missed releases of 0",
                  "d.slow counted 2 releases, with those missed, busy or not in the tables, of 1",
                  "d.program counted 1 overruns of 0", "d.sporadic counted 3 steps of 2",
                  "d.urgent is in EXECUTING, and its steps lead to START",
                  "connection d.fast.out to d.slow.in: a sample was written, and not taken, "
                  "overwritten or left there"));
}

TEST_F(InvariantsTest, ARowThatACrashCutShortIsMissed) {
  begin();
  row(0);
  wake(1);
  hear({.what = What::run, .module = kFast, .number = 1, .release = at(due(1))});
  hear({.what = What::host_ended});
  for (const std::uint32_t module : {kFast, kSlow, kSporadic, kUrgent})
    hear({.what = What::taken_out, .module = module});
  hear({.what = What::joined, .executor = 0, .number = 3, .count = 2, .release = at(due(3))},
       due(3) - microseconds{5});
  checker.close(0, {.executors = {{.cycles = 1, .missed = 2, .next_row = 3}},
                    .modules = {counted(1), counted(1), counted(1, 2), counted(0), counted(0)}});
  EXPECT_THAT(said(), IsEmpty());
}

}  // namespace
}  // namespace takt::simulation::invariants_test
