#include <takt/schedule/longest_runs.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::schedule::longest_runs_test {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::Optional;

/// Returns a cell whose device robot has the modules a (in line 1 of the file), b (in line 2) and logger,
/// which is not real-time.
model::Cell cell() {
  model::Cell cell;
  cell.name = "cell";
  cell.file = "cell.xml";
  model::Device& device = cell.devices.emplace_back();
  device.name = "robot";
  for (const char* name : {"a", "b", "logger"}) {
    model::Module& module = device.modules.emplace_back();
    module.name = name;
    module.line = static_cast<int>(device.modules.size());
  }
  device.modules[2].operation = model::Operation::non_real;
  return cell;
}

model::Profile profile() {
  return {.cell = "cell",
          .modules = {{"robot.a", {.runs = 5, .min = 1us, .p50 = 1us, .p99 = 2us, .p999 = 2us, .max = 3us}},
                      {"robot.b", {}}}};
}

TEST(LongestRuns, AreTheMeasuredTimesOrOtherwiseTheBudgets) {
  auto all = cell();
  all.devices[0].modules[0].budget = 9us;
  all.devices[0].modules[1].budget = 7us;
  const auto measured = profile();
  const auto runs = longest_runs(all, &measured, 1);
  ASSERT_TRUE(runs);
  EXPECT_THAT((*runs)[0], ElementsAre(Optional(3000ns), Optional(7000ns), std::nullopt));
  EXPECT_THAT((*longest_runs(all, nullptr, 1))[0],
              ElementsAre(Optional(9000ns), Optional(7000ns), std::nullopt));
}

TEST(LongestRuns, AreMultipliedByTheFactorAndRoundedUp) {
  auto all = cell();
  all.devices[0].modules[0].budget = 3ns;
  all.devices[0].modules[1].budget = Nanoseconds::max();
  const auto runs = longest_runs(all, nullptr, 1.5);
  ASSERT_TRUE(runs);
  EXPECT_EQ((*runs)[0][0], 5ns);
  EXPECT_EQ((*runs)[0][1], Nanoseconds::max());
}

TEST(LongestRuns, ReportAModuleWithNeitherAMeasurementNorABudget) {
  const auto measured = profile();
  const auto runs = longest_runs(cell(), &measured, 1);
  ASSERT_FALSE(runs);
  EXPECT_THAT(runs.problems(), ElementsAre(AllOf(Field(&Problem::where, "cell.xml:2"),
                                                 Field(&Problem::what, HasSubstr("'robot.b'")),
                                                 Field(&Problem::fix, HasSubstr("<budget>")))));
}

TEST(LongestRuns, RejectAProfileOfAnotherCell) {
  auto measured = profile();
  measured.cell = "other";
  auto all = cell();
  all.devices[0].modules[1].budget = 1us;
  const auto runs = longest_runs(all, &measured, 1);
  ASSERT_FALSE(runs);
  EXPECT_THAT(runs.problems(),
              ElementsAre(Field(&Problem::what, HasSubstr("the profile belongs to cell 'other'"))));
}

TEST(BudgetCheck, IgnoresNonRealTimeModules) {
  auto all = cell();
  EXPECT_FALSE(all_state_budgets(all));
  all.devices[0].modules[0].budget = 1us;
  EXPECT_FALSE(all_state_budgets(all));
  all.devices[0].modules[1].budget = 1us;
  EXPECT_TRUE(all_state_budgets(all));
  for (model::Module& module : all.devices[0].modules) module.operation = model::Operation::non_real;
  EXPECT_FALSE(all_state_budgets(all)) << "there is nothing to prove";
}

}  // namespace
}  // namespace takt::schedule::longest_runs_test
