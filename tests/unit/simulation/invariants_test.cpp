// Tests the checks of the invariants. Some tests simulate a correct run, in which the checks must find no
// violation. The other tests break one rule each.
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
constexpr std::uint32_t kFast = 0;      // due in every row; runs second
constexpr std::uint32_t kSlow = 1;      // due in every second row; runs first
constexpr std::uint32_t kProgram = 2;   // due in every row; runs last
constexpr std::uint32_t kSporadic = 3;  // sporadic, deadline 5 ms
constexpr std::uint32_t kUrgent = 4;    // sporadic, deadline 1 ms

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

class InvariantChecks : public testing::Test {
 protected:
  static Instant at(Nanoseconds since) { return kStart + since; }
  void add(Event event, Nanoseconds since = now_) {
    event.at = at(since);
    event.device = 0;
    if (event.connection != Event::kNone) event.device = Event::kNone;
    checker.on_event(event);
  }
  void step(std::uint32_t module, lifecycle::Event event, State from, State to, std::uint64_t sequence) {
    add({.what = What::step,
         .module = module,
         .step = {.from = from, .to = to, .event = event, .sequence = sequence}});
  }
  void begin(std::uint32_t module) {
    using lifecycle::Event;
    step(module, Event::initialize, State::idle, State::initialize, 1);
    step(module, Event::start, State::initialize, State::start, 2);
    add({.what = What::put_in, .module = module});
  }
  void begin() {
    for (std::uint32_t m = 0; m < cell.devices[0].modules.size(); ++m) begin(m);
    add({.what = What::joined, .executor = 0, .number = 0, .release = kStart}, -milliseconds{1});
  }
  static Nanoseconds due(std::uint64_t row) { return milliseconds{1} * static_cast<std::int64_t>(row); }
  void wake(std::uint64_t row, Nanoseconds late = microseconds{1}) {
    now_ = due(row) + late;
    add({.what = What::woke, .executor = 0, .number = row, .release = at(due(row))});
  }
  void run(std::uint32_t module, std::uint64_t number, Nanoseconds release,
           ErrorType error = ErrorType::none) {
    add({.what = What::run, .module = module, .number = number, .release = at(release)});
    now_ += microseconds{10};
    add({.what = What::ran, .module = module, .number = number, .error = error});
  }
  void release(std::uint64_t number, Nanoseconds of) {
    add({.what = What::released, .module = kProgram, .number = number, .release = at(of)});
  }
  void walked(std::uint64_t row, std::uint64_t missed = 0) {
    add({.what = What::walked, .executor = 0, .number = row, .count = missed, .release = at(due(row))});
  }
  void row(std::uint64_t n) {
    wake(n);
    if (n % 2 == 0) run(kSlow, n / 2, due(n));
    run(kFast, n, due(n));
    release(n, due(n));
    walked(n);
  }
  const std::vector<std::string>& violations() const { return checker.violations(); }

  static inline Nanoseconds now_{};
  model::Cell cell = make_cell();
  std::vector<schedule::DevicePlan> plans = *schedule::plan(cell);
  Invariants checker{cell, plans, kStart};
};

Totals::OfModule counted(std::uint64_t cycles, std::uint64_t missed = 0) {
  return {.cycles = cycles, .missed = missed, .state = State::start, .steps = 2};
}

TEST_F(InvariantChecks, FindNothingInACorrectRun) {
  begin();
  for (std::uint64_t n = 0; n < 4; ++n) row(n);
  checker.close(0, {.executors = {{.cycles = 4, .missed = 0, .next_row = 4}},
                    .modules = {counted(4), counted(2), counted(4), counted(0), counted(0)}});
  EXPECT_THAT(violations(), IsEmpty());
}

TEST_F(InvariantChecks, AcceptCorrectlyCountedMissedRows) {
  begin();
  row(0);
  wake(1, milliseconds{2});  // wakes up 2 ms late, in the slot of row 3
  run(kFast, 3, due(3));
  release(3, due(3));
  walked(3, 2);
  checker.close(0, {.executors = {{.cycles = 2, .missed = 2, .next_row = 4}},
                    .modules = {counted(2, 2), counted(1, 1), counted(2, 2), counted(0), counted(0)}});
  EXPECT_THAT(violations(), IsEmpty());
}

TEST_F(InvariantChecks, FindARowOffTheGrid) {
  begin();
  row(0);
  add({.what = What::woke, .executor = 0, .number = 1, .release = at(due(1) + Nanoseconds{1})},
      due(1) + microseconds{2});
  EXPECT_THAT(violations(), ElementsAre(HasSubstr("the row is not on the grid")));
}

TEST_F(InvariantChecks, FindARowOutsideItsSlot) {
  begin();
  wake(0, milliseconds{1});
  run(kSlow, 0, due(0));
  run(kFast, 0, due(0));
  release(0, due(0));
  walked(0);
  EXPECT_THAT(violations(), ElementsAre(HasSubstr("in the slot of another row")));
}

TEST_F(InvariantChecks, FindARowThatIsEarlyRepeatedOrLost) {
  begin();
  wake(0, -microseconds{1});
  EXPECT_THAT(violations(), Contains(HasSubstr("woke too early")));
  walked(0);
  row(0);
  EXPECT_THAT(violations(), Contains(HasSubstr("expected row 1")));
  row(2);
  EXPECT_THAT(violations(),
              Contains(HasSubstr("d executor main woke 1000 ns after its release: expected row 1")));
  wake(3);
  walked(4);
  EXPECT_THAT(violations(), Contains(HasSubstr("rows are lost")));
}

TEST_F(InvariantChecks, FindModulesInTheWrongOrderInARow) {
  begin();
  wake(0);
  run(kFast, 0, due(0));
  run(kSlow, 0, due(0));
  release(0, due(0));
  walked(0);
  EXPECT_THAT(violations(), Contains(HasSubstr("in the wrong place")));
}

TEST_F(InvariantChecks, FindAModuleThatARowOmits) {
  begin();
  wake(0);
  run(kSlow, 0, due(0));
  run(kFast, 0, due(0));
  walked(0);
  EXPECT_THAT(violations(), ElementsAre(HasSubstr("program was not served at its place in the row")));
}

TEST_F(InvariantChecks, FindAModuleServedTwiceOrWhenNotDue) {
  begin();
  wake(0);
  run(kSlow, 0, due(0));
  run(kFast, 0, due(0));
  release(0, due(0));
  release(0, due(0));
  walked(0);
  EXPECT_THAT(violations(), ElementsAre(HasSubstr("program was served in the wrong place")));
  wake(1);
  run(kSlow, 0, due(1));
  walked(1);
  EXPECT_THAT(violations(), Contains(HasSubstr("slow was served in the wrong place")));
}

TEST_F(InvariantChecks, FindAWrongReleaseTime) {
  begin();
  wake(0);
  run(kSlow, 0, due(0));
  run(kFast, 1, due(0));
  release(0, due(1));
  walked(0);
  EXPECT_THAT(violations(),
              ElementsAre(HasSubstr("fast got a wrong release"), HasSubstr("program got a wrong release")));
}

TEST_F(InvariantChecks, FindAModuleServedWhileOutOfTheTables) {
  begin();
  add({.what = What::taken_out, .module = kProgram});
  add({.what = What::taken_out, .module = kSlow});
  row(0);
  EXPECT_THAT(violations(), ElementsAre(HasSubstr("d.slow run 0 of +0.000000000: it is not in the tables"),
                                        HasSubstr("slow was served while it was out of the tables"),
                                        HasSubstr("program was served while it was out of the tables")));
}

TEST_F(InvariantChecks, FindAFailedModuleLeftInTheTables) {
  begin();
  wake(0);
  run(kSlow, 0, due(0));
  run(kFast, 0, due(0), ErrorType::failure);
  release(0, due(0));
  walked(0);
  row(1);
  EXPECT_THAT(
      violations(),
      ElementsAre(HasSubstr("d.fast run 1 of +0.001000000: it has failed but is still in the tables")));
}

TEST_F(InvariantChecks, FindAnErrorThatIsNotHandled) {
  begin();
  add({.what = What::taken_out, .module = kFast, .error = ErrorType::budget});
  add({.what = What::put_in, .module = kFast});
  EXPECT_THAT(violations(), ElementsAre(HasSubstr("its error was not handled")));
}

TEST_F(InvariantChecks, FindTransitionsThatAreMissingOrNotInTheLifecycleTable) {
  using lifecycle::Event;
  begin();
  step(kFast, Event::initialize, State::start, State::executing, 3);
  EXPECT_THAT(violations(), ElementsAre(HasSubstr("the lifecycle's table has no such step")));
  step(kFast, Event::stop, State::executing, State::start, 5);
  EXPECT_THAT(violations(), Contains(HasSubstr("step 4 is missing")));
  step(kSlow, Event::stop, State::executing, State::start, 3);
  EXPECT_THAT(violations(), Contains(HasSubstr("its state was START")));
}

TEST_F(InvariantChecks, FindAModuleInTheTablesThatIsNotExecuting) {
  begin();
  step(kFast, lifecycle::Event::error, State::start, State::recover, 3);
  EXPECT_THAT(violations(), ElementsAre(HasSubstr("it is in the tables")));
}

TEST_F(InvariantChecks, FindASporadicRunThatWasNotReady) {
  begin();
  add({.what = What::ready, .module = kSporadic, .release = kStart, .until = at(milliseconds{5})});
  run(kSporadic, 0, {});
  EXPECT_THAT(violations(), IsEmpty());
  run(kSporadic, 0, {});
  EXPECT_THAT(violations(), ElementsAre(HasSubstr("it was not ready")));
}

TEST_F(InvariantChecks, FindASporadicRunThatDelaysAnEarlierDeadline) {
  begin();
  add({.what = What::ready, .module = kSporadic, .release = kStart, .until = at(milliseconds{5})});
  add({.what = What::ready, .module = kUrgent, .release = kStart, .until = at(milliseconds{1})});
  run(kSporadic, 0, {});
  EXPECT_THAT(violations(), ElementsAre(HasSubstr("urgent has an earlier deadline")));
}

TEST_F(InvariantChecks, FindASporadicReleaseThatIsTooEarlyOrRepeated) {
  begin();
  add({.what = What::ready, .module = kUrgent, .release = kStart, .until = at(milliseconds{1})});
  add({.what = What::ready, .module = kUrgent, .release = at(milliseconds{1}), .until = at(milliseconds{2})});
  EXPECT_THAT(violations(), ElementsAre(HasSubstr("checked again before it had run"),
                                        HasSubstr("before its interarrival time had passed")));
  add({.what = What::ready, .module = kSporadic, .release = kStart, .until = at(milliseconds{4})});
  EXPECT_THAT(violations(), Contains(HasSubstr("the deadline of this run is wrong")));
}

TEST_F(InvariantChecks, FindTwoModulesRunningOnOneThread) {
  begin();
  wake(0);
  add({.what = What::run, .module = kSlow, .number = 0, .release = kStart});
  add({.what = What::run, .module = kFast, .number = 0, .release = kStart});
  EXPECT_THAT(violations(), ElementsAre(HasSubstr("another module of the row is running")));
  add({.what = What::ran, .module = kSlow});
  EXPECT_THAT(violations(), Contains(HasSubstr("it was not running")));
}

TEST_F(InvariantChecks, FindSamplesThatAreTornRepeatedOrOutOfOrder) {
  const auto sample = [this](What what, std::uint64_t number, std::uint64_t torn = 0) {
    add({.what = what, .connection = 0, .number = number, .count = torn});
  };
  sample(What::wrote, 1);
  sample(What::wrote, 2);
  sample(What::read, 2);
  EXPECT_THAT(violations(), IsEmpty());
  sample(What::read, 2);
  sample(What::read, 1);
  sample(What::read, 3);
  sample(What::read, 4, 1);
  sample(What::wrote, 4);
  sample(What::arrived, 2);
  sample(What::arrived, 2);
  sample(What::arrived, 5);
  EXPECT_THAT(violations(),
              ElementsAre(HasSubstr("2 was read earlier"), HasSubstr("2 was read earlier"),
                          HasSubstr("not written yet"), HasSubstr("bytes are not those of one sample"),
                          HasSubstr("expected number 3"), HasSubstr("2 arrived earlier"),
                          HasSubstr("not written yet")));
}

TEST_F(InvariantChecks, FindCountersThatDoNotMatchTheEvents) {
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
      violations(),
      ElementsAre("d executor main counted 2 rows but there were 1",
                  "d executor main counted 2 executed or missed rows but there were 1",
                  "d.fast counted 2 releases but there were 1",
                  "d.fast counted 2 releases including missed, busy and omitted ones but there were 1",
                  "d.slow counted 1 missed releases but there were 0",
                  "d.slow counted 2 releases including missed, busy and omitted ones but there were 1",
                  "d.program counted 1 overruns but there were 0",
                  "d.sporadic counted 3 steps but there were 2",
                  "d.urgent is in EXECUTING, but its steps lead to START",
                  "connection d.fast.out to d.slow.in: a written sample was neither taken nor overwritten, "
                  "but is gone"));
}

TEST_F(InvariantChecks, CountARowInterruptedByACrashAsMissed) {
  begin();
  row(0);
  wake(1);
  add({.what = What::run, .module = kFast, .number = 1, .release = at(due(1))});
  add({.what = What::host_ended, .host = 0});
  for (const std::uint32_t module : {kFast, kSlow, kSporadic, kUrgent})
    add({.what = What::taken_out, .module = module});
  add({.what = What::joined, .executor = 0, .number = 3, .count = 2, .release = at(due(3))},
      due(3) - microseconds{5});
  checker.close(0, {.executors = {{.cycles = 1, .missed = 2, .next_row = 3}},
                    .modules = {counted(1), counted(1), counted(1, 2), counted(0), counted(0)}});
  EXPECT_THAT(violations(), IsEmpty());
}

}  // namespace
}  // namespace takt::simulation::invariants_test
