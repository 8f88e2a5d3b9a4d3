#include <takt/schedule/plan.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::schedule::plan_test {
namespace {

using namespace std::chrono_literals;
using model::Cell;
using model::Device;
using model::Module;
using model::ModuleType;
using model::Operation;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using Names = std::vector<std::string>;

Module periodic(std::string name, Nanoseconds period, int priority = 0) {
  Module module;
  module.name = std::move(name);
  module.period = period;
  module.priority = priority;
  module.executor = "main";
  return module;
}

Module sporadic(std::string name, Nanoseconds deadline, int priority = 0) {
  Module module = periodic(std::move(name), deadline, priority);
  std::swap(module.period, module.deadline);
  module.operation = Operation::sporadic;
  return module;
}

Module non_real(std::string name, int priority = 0) {
  Module module;
  module.name = std::move(name);
  module.operation = Operation::non_real;
  module.priority = priority;
  return module;
}

Module process(Module module) {
  module.type = ModuleType::process;
  return module;
}

Module with_budget(Module module, Nanoseconds budget) {
  module.budget = budget;
  return module;
}

Module with_interarrival(Module module, Nanoseconds interarrival) {
  module.interarrival = interarrival;
  module.lines.interarrival = 14;
  return module;
}

/// Returns a cell with these modules, which are defined in lines 10, 20, 30 and so on of cell.xml.
Cell cell_of(std::vector<Module> modules) {
  Cell cell;
  cell.name = "cell";
  cell.file = "cell.xml";
  Device device;
  device.name = "robot";
  device.executors.emplace_back();
  for (std::size_t i = 0; i < modules.size(); ++i) modules[i].line = static_cast<int>(i + 1) * 10;
  device.modules = std::move(modules);
  cell.devices.push_back(std::move(device));
  return cell;
}

/// Returns the paper's Figure 1 as a cell.
Cell figure1() {
  return cell_of({periodic("controller1", 600us, 3), periodic("control2", 100us, 2),
                  periodic("control3", 100us, 1), process(periodic("control4", 300us, 4)),
                  sporadic("emergency", 100us, 1), process(sporadic("vision", 10ms, 2)),
                  process(non_real("monitoring"))});
}

Names names(const Device& device, const std::vector<std::uint32_t>& modules) {
  Names result;
  for (const auto index : modules) result.push_back(device.modules[index].name);
  return result;
}

Problems problems_of(const Cell& cell) {
  auto result = plan(cell);
  return result ? Problems{} : result.problems();
}

TEST(Plan, HasTheTablesOfFigures3And4ForTheModulesOfFigure1) {
  const Cell cell = figure1();
  const Device& device = cell.devices.front();
  const auto result = plan(cell, device);
  ASSERT_TRUE(result);
  ASSERT_EQ(result->executors.size(), 1U);
  const ExecutorPlan& main = result->executors.front();
  EXPECT_EQ(main.basic_period, 100us);
  EXPECT_EQ(main.macro_period, 600us);
  ASSERT_EQ(main.rows(), 6U);
  EXPECT_EQ(names(device, main.row(0)), (Names{"control3", "control2", "controller1", "control4"}));
  EXPECT_EQ(names(device, main.row(1)), (Names{"control3", "control2"}));
  EXPECT_EQ(names(device, main.row(2)), (Names{"control3", "control2"}));
  EXPECT_EQ(names(device, main.row(3)), (Names{"control3", "control2", "control4"}));
  EXPECT_EQ(names(device, main.row(4)), (Names{"control3", "control2"}));
  EXPECT_EQ(names(device, main.row(5)), (Names{"control3", "control2"}));
  EXPECT_EQ(names(device, main.sporadic), (Names{"emergency", "vision"}));
  EXPECT_EQ(names(device, result->non_realtime), (Names{"monitoring"}));
}

TEST(Plan, AllowsAnExecutorWithoutModules) {
  const Cell cell = cell_of({});
  const auto result = plan(cell, cell.devices.front());
  ASSERT_TRUE(result);
  ASSERT_EQ(result->executors.size(), 1U);
  EXPECT_EQ(result->executors[0].rows(), 0U);
  EXPECT_EQ(result->executors[0].basic_period, 0ns);
  EXPECT_EQ(result->executors[0].macro_period, 0ns);
}

TEST(Plan, ChecksConditionsTwicePerDeadlineIfAllModulesAreSporadic) {
  const Cell cell = cell_of({sporadic("slow", 7ms, 1), sporadic("fast", 5ms, 2)});
  const auto result = plan(cell, cell.devices.front());
  ASSERT_TRUE(result);
  const ExecutorPlan& main = result->executors.front();
  EXPECT_EQ(main.basic_period, 2500us);
  EXPECT_EQ(main.macro_period, 2500us);
  ASSERT_EQ(main.rows(), 1U);
  EXPECT_THAT(main.row(0), IsEmpty());
  EXPECT_EQ(main.load(cell.devices.front(), 0).budget, 0ns);
  EXPECT_THAT(main.sporadic, ElementsAre(0U, 1U));
}

TEST(Plan, ChecksConditionsAtMostOncePerNanosecond) {
  const Cell cell = cell_of({sporadic("eager", 1ns)});
  const auto result = plan(cell, cell.devices.front());
  ASSERT_TRUE(result);
  EXPECT_EQ(result->executors.front().basic_period, 1ns);
}

TEST(Plan, GivesEachExecutorItsOwnTables) {
  Cell cell = cell_of(
      {periodic("servo", 1ms), periodic("camera", 33ms), periodic("filter", 2ms), sporadic("alarm", 5ms)});
  Device& device = cell.devices.front();
  device.executors.resize(3);
  device.executors[1].name = "slow";
  device.executors[2].name = "spare";
  device.modules[1].executor = "slow";
  device.modules[3].executor = "slow";
  const auto result = plan(cell, device);
  ASSERT_TRUE(result);
  ASSERT_EQ(result->executors.size(), 3U);
  EXPECT_THAT(result->executors[0].periodic, ElementsAre(0U, 2U));
  EXPECT_EQ(result->executors[0].macro_period, 2ms);
  EXPECT_THAT(result->executors[0].row(0), ElementsAre(0U, 2U));
  EXPECT_THAT(result->executors[0].sporadic, IsEmpty());
  EXPECT_EQ(result->executors[1].executor, 1U);
  EXPECT_EQ(result->executors[1].basic_period, 33ms);
  EXPECT_THAT(result->executors[1].row(0), ElementsAre(1U));
  EXPECT_THAT(result->executors[1].sporadic, ElementsAre(3U));
  EXPECT_EQ(result->executors[2].rows(), 0U);
}

TEST(Plan, OrdersModulesByPriorityThenAsInTheDescriptor) {
  const Cell cell = cell_of({sporadic("a", 1ms, 7), sporadic("b", 1ms, -1), sporadic("c", 1ms, 7),
                             non_real("d", 2), non_real("e", 1), non_real("f", 2)});
  const auto result = plan(cell, cell.devices.front());
  ASSERT_TRUE(result);
  EXPECT_THAT(result->executors[0].sporadic, ElementsAre(1U, 0U, 2U));
  EXPECT_THAT(result->non_realtime, ElementsAre(4U, 3U, 5U));
}

TEST(Plan, NamesTwoModulesWhosePeriodsMakeTheTableTooLong) {
  const Cell cell = cell_of({periodic("servo", 1ms), periodic("camera", 33'333'333ns), periodic("log", 1s)});
  const Problems problems = problems_of(cell);
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_EQ(problems[0].where, "cell.xml:30");
  EXPECT_THAT(problems[0].what, AllOf(HasSubstr("executor 'main'"), HasSubstr("basic period 1 ns"),
                                      HasSubstr("'camera' with 33333.333 us"), HasSubstr("'log' with 1 s"),
                                      HasSubstr("entries, at most 1000000")));
  EXPECT_EQ(problems[0].fix, "give 'camera' a period of 33 ms, or give each module its own executor");
}

TEST(Plan, RejectsPeriodsWithTooLargeACommonMultiple) {
  const Problems problems = problems_of(cell_of({periodic("a", Nanoseconds::max()), periodic("b", 2ns)}));
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_THAT(problems[0].what,
              AllOf(HasSubstr("macro period more than 10^18 ns"), HasSubstr("'a'"), HasSubstr("'b'")));
}

TEST(Plan, ReportsTheProblemsOfAllExecutorsAndDevices) {
  Cell cell = cell_of({periodic("a", 1ns), periodic("b", 1s), periodic("c", 1ns), periodic("d", 1s)});
  cell.devices[0].executors.resize(2);
  cell.devices[0].executors[1].name = "second";
  cell.devices[0].modules[2].executor = cell.devices[0].modules[3].executor = "second";
  cell.devices.push_back(cell.devices[0]);
  cell.devices.push_back(cell_of({periodic("fine", 1s)}).devices[0]);
  EXPECT_EQ(problems_of(cell).size(), 4U);
}

TEST(Plan, ReportsTheModuleInsteadOfALineIfTheCellHasNoFile) {
  Cell cell = cell_of({with_budget(periodic("servo", 1ms), 2ms)});
  cell.file.clear();
  const Problems problems = problems_of(cell);
  ASSERT_FALSE(problems.empty());
  EXPECT_EQ(problems[0].where, "module servo");
}

// ---- Budgets

TEST(Budget, MayFillThePeriodButNotExceedIt) {
  EXPECT_THAT(problems_of(cell_of({process(with_budget(periodic("a", 1ms), 1ms))})), IsEmpty());
  const Problems problems =
      problems_of(cell_of({periodic("z", 1ms), process(with_budget(periodic("a", 1ms), 1ms + 1ns))}));
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_EQ(problems[0].where, "cell.xml:20");
  EXPECT_THAT(problems[0].what, AllOf(HasSubstr("'a'"), HasSubstr("1000.001 us"), HasSubstr("period, 1 ms")));
  EXPECT_FALSE(problems[0].fix.empty());
}

TEST(Budget, MayFillTheDeadlineButNotExceedIt) {
  EXPECT_THAT(problems_of(cell_of({with_budget(sporadic("a", 1ms), 1ms)})), IsEmpty());
  const Problems problems = problems_of(cell_of({with_budget(sporadic("a", 1ms), 2ms)}));
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_EQ(problems[0].where, "cell.xml:10");
  EXPECT_THAT(problems[0].what, HasSubstr("deadline, 1 ms"));
}

TEST(Plan, RejectsAnInterarrivalTimeShorterThanTheBudget) {
  const Module a = with_budget(sporadic("a", 5ms), 200us);
  EXPECT_THAT(problems_of(cell_of({periodic("b", 1ms), with_interarrival(a, 200us)})), IsEmpty());
  const Problems problems = problems_of(cell_of({with_interarrival(a, 50us), periodic("b", 1ms)}));
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_EQ(to_text(problems),
            "cell.xml:14: error: the interarrival time of 'a', 50 us, is shorter than its budget, 200 us; "
            "lengthen the <interarrival> to at least 200 us, or reduce the budget: a run must end before the "
            "next release");
}

TEST(Budget, MayFillTheRowInTotalButNotExceedIt) {
  EXPECT_THAT(
      problems_of(cell_of({with_budget(periodic("a", 1ms), 600us), with_budget(periodic("b", 1ms), 400us)})),
      IsEmpty());
  const Problems problems = problems_of(
      cell_of({with_budget(periodic("a", 1ms), 400us), with_budget(periodic("b", 2ms), 600us + 1ns)}));
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_EQ(problems[0].where, "cell.xml:20");
  EXPECT_THAT(problems[0].what,
              AllOf(HasSubstr("row 0"), HasSubstr("executor 'main'"), HasSubstr("a 400 us, b 600.001 us"),
                    HasSubstr("1000.001 us, but the basic period is 1 ms"), HasSubstr("1 of 2 rows")));
  EXPECT_FALSE(problems[0].fix.empty());
}

TEST(Budget, CountsInTheRowOnlyForPeriodicThreadModules) {
  EXPECT_THAT(problems_of(cell_of({with_budget(periodic("a", 1ms), 800us),
                                   process(with_budget(periodic("b", 1ms), 900us)),
                                   with_budget(sporadic("c", 1ms), 900us)})),
              IsEmpty());
}

TEST(BudgetProblem, NamesTheFullestRowAndCountsTheOverfullRows) {
  // Modules a and b are due in every row, module c in every second row, and module d in every third row. All
  // four are due in row 0.
  const Problems problems =
      problems_of(cell_of({with_budget(periodic("a", 1ms), 500us), with_budget(periodic("b", 1ms), 300us),
                           with_budget(periodic("c", 2ms), 300us), with_budget(periodic("d", 3ms), 400us)}));
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_THAT(problems[0].what, AllOf(HasSubstr("row 0"), HasSubstr("1.5 ms, but the basic period is 1 ms"),
                                      HasSubstr("4 of 6 rows")));
}

TEST(BudgetProblem, NamesTheOffsetThatMakesTheRowsTooShort) {
  Module servo = with_budget(periodic("servo", 1ms), 800us);
  servo.offset = 1ns;
  servo.lines.offset = 77;
  const Problems problems = problems_of(cell_of({servo, periodic("arm", 1ms)}));
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_EQ(problems[0].where, "cell.xml:77");
  EXPECT_EQ(
      problems[0].what,
      "the offset of 'servo', 1 ns, shortens the basic period of executor 'main' from 1 ms to 1 ns, which is "
      "too short for the budget of row 1: servo 800 us");
  EXPECT_EQ(problems[0].fix, "choose an offset that is a multiple of 1 ms, or reduce the budgets");
}

TEST(BudgetProblem, NamesAtMostTwelveModules) {
  std::vector<Module> modules;
  for (int i = 0; i < 100; ++i) modules.push_back(with_budget(periodic("m" + std::to_string(i), 1ms), 11us));
  const Problems problems = problems_of(cell_of(modules));
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_THAT(problems[0].what, AllOf(HasSubstr("m11 11 us and 88 more"), Not(HasSubstr("m12"))));
}

TEST(Budget, DoesNotOverflowInSums) {
  const Nanoseconds huge = Nanoseconds::max();
  const Cell cell = cell_of({with_budget(periodic("a", huge), huge), with_budget(periodic("b", huge), huge)});
  const Problems problems = problems_of(cell);
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_THAT(problems[0].what, HasSubstr("add up to more than 10^18 ns"));
}

TEST(Load, IsMarkedIncompleteIfAThreadModuleHasNoBudget) {
  const Cell cell =
      cell_of({with_budget(periodic("a", 1ms), 100us), periodic("b", 2ms), process(periodic("c", 1ms))});
  const Device& device = cell.devices.front();
  const auto result = plan(cell, device);
  ASSERT_TRUE(result);
  const ExecutorPlan& main = result->executors.front();
  EXPECT_EQ(main.load(device, 0).budget, 100us);
  EXPECT_FALSE(main.load(device, 0).complete);
  EXPECT_EQ(main.load(device, 1).budget, 100us);
  EXPECT_TRUE(main.load(device, 1).complete);
}

TEST(Plan, ReducesTheFullestRowOfThePapersFigure1) {
  Cell cell = figure1();
  cell.devices[0].executors[0].offsets = model::Offsets::automatic;
  const auto result = plan(cell, cell.devices[0]);
  ASSERT_TRUE(result);
  const ExecutorPlan& main = result->executors.front();
  EXPECT_EQ(main.basic_period, 100us);
  ASSERT_EQ(main.rows(), 6U);
  std::size_t most = 0;
  for (std::size_t row = 0; row < main.rows(); ++row) most = std::max(most, main.row(row).size());
  EXPECT_EQ(most, 3U) << "without offsets it is four";
  EXPECT_EQ(main.table.entries(), 15U) << "the same number as without offsets";
}

TEST(Plan, BalancesTheBudgetsOfTheRowsIfAllThreadModulesHaveOne) {
  Cell cell = cell_of({with_budget(periodic("heavy", 2ms), 900us), with_budget(periodic("a", 2ms), 500us),
                       with_budget(periodic("b", 2ms), 400us), process(periodic("c", 1ms))});
  cell.devices[0].executors[0].offsets = model::Offsets::automatic;
  const auto result = plan(cell, cell.devices[0]);
  ASSERT_TRUE(result) << "with offsets, each row must fit: " << to_text(result.problems());
  const ExecutorPlan& main = result->executors.front();
  EXPECT_EQ(main.load(cell.devices[0], 0).budget, 900us);
  EXPECT_EQ(main.load(cell.devices[0], 1).budget, 900us);
}

TEST(Plan, AppliesTheGivenOffsets) {
  Cell cell = cell_of({periodic("a", 2ms), periodic("b", 2ms), periodic("c", 4ms)});
  cell.devices[0].modules[1].offset = 1ms;
  cell.devices[0].modules[2].offset = 500us;
  const auto result = plan(cell, cell.devices[0]);
  ASSERT_TRUE(result);
  const ExecutorPlan& main = result->executors.front();
  EXPECT_EQ(main.basic_period, 500us);
  EXPECT_EQ(main.macro_period, 4ms);
  EXPECT_THAT(main.offsets, ElementsAre(0us, 1ms, 500us));
  const Device& device = cell.devices[0];
  const std::vector<Names> rows{{"a"}, {"c"}, {"b"}, {}, {"a"}, {}, {"b"}, {}};
  ASSERT_EQ(main.rows(), rows.size());
  for (std::size_t row = 0; row < rows.size(); ++row)
    EXPECT_EQ(names(device, main.row(row)), rows[row]) << row;
  EXPECT_EQ(offset_of(main, 2), 500us);
}

TEST(Plan, NamesTheOffsetThatMakesTheTableTooLong) {
  Cell cell = cell_of({periodic("a", 1ms), periodic("b", 7ms), periodic("c", 100ms)});
  cell.devices[0].modules[1].offset = 1ns;
  const Problems problems = problems_of(cell);
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_THAT(problems[0].what, AllOf(HasSubstr("'b' has an offset of 1 ns"), HasSubstr("1 ms")));
  EXPECT_THAT(problems[0].fix, HasSubstr("multiples of 1 ms"));
}

TEST(Plan, GivesTheHighestPriorityToTheRateMonotonicExecutorWithTheShortestPeriod) {
  Cell cell = cell_of({periodic("slow", 10ms), periodic("fast", 1ms), periodic("mid", 5ms),
                       periodic("other", 1ms), periodic("fixed", 2ms)});
  Device& device = cell.devices[0];
  device.executors.clear();
  for (Module& module : device.modules) {
    module.executor = module.name;
    model::Executor executor;
    executor.name = module.name;
    executor.rate_monotonic = module.name != "fixed";
    executor.priority = 42;
    device.executors.push_back(executor);
  }
  const auto result = plan(cell, device);
  ASSERT_TRUE(result);
  std::vector<int> priorities;
  for (const ExecutorPlan& executor : result->executors) priorities.push_back(executor.priority);
  EXPECT_THAT(priorities, ElementsAre(60, 80, 70, 80, 42));
}

TEST(Plan, AssignsPrioritiesTo64DifferentPeriods) {
  std::vector<Module> modules;
  for (int i = 0; i < 64; ++i) modules.push_back(periodic("m" + std::to_string(i), 1ms * (i + 1)));
  Cell cell = cell_of(std::move(modules));
  Device& device = cell.devices[0];
  device.executors.clear();
  for (Module& module : device.modules) {
    module.executor = module.name;
    device.executors.emplace_back().name = module.name;
    device.executors.back().rate_monotonic = true;
  }
  const auto result = plan(cell, device);
  ASSERT_TRUE(result);
  for (std::size_t i = 1; i < result->executors.size(); ++i) {
    EXPECT_LE(result->executors[i].priority, result->executors[i - 1].priority);
    EXPECT_GE(result->executors[i].priority, 10) << "programs run up to nine below";
  }
}

}  // namespace
}  // namespace takt::schedule::plan_test
