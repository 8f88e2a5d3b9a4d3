#include <takt/schedule/analysis.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <utility>

namespace takt::schedule::analysis_test {
namespace {

using namespace std::chrono_literals;
using model::Cell;
using model::Device;
using model::Dispatch;
using model::Module;
using model::ModuleType;
using model::Operation;
using model::Wakeup;
using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;

/// Builds a device and the longest run time of each module. By default, the executors of the device do not
/// spin, so that expected values are easy to compute.
class Cells {
 public:
  explicit Cells(int executors = 1) {
    cell.name = "cell";
    cell.file = "cell.xml";
    Device& d = cell.devices.emplace_back();
    d.name = "robot";
    for (int i = 0; i < executors; ++i) {
      model::Executor& executor = d.executors.emplace_back();
      executor.name = "e" + std::to_string(i);
      executor.priority = 80 - 10 * i;
      executor.wakeup = Wakeup::sleep;
    }
  }

  Module& periodic(const std::string& name, Nanoseconds period, Nanoseconds run, int executor = 0) {
    Module& module = add(name, run, executor);
    module.period = period;
    return module;
  }
  Module& sporadic(const std::string& name, Nanoseconds deadline, Nanoseconds run, int executor = 0) {
    Module& module = add(name, run, executor);
    module.operation = Operation::sporadic;
    module.deadline = deadline;
    return module;
  }
  model::Executor& executor(int i = 0) { return device().executors[static_cast<std::size_t>(i)]; }
  Device& device() { return cell.devices.front(); }

  [[nodiscard]] std::vector<WorstCase> worst(int number_of_cpus = 2) {
    std::vector<int> cpus(static_cast<std::size_t>(number_of_cpus));
    std::iota(cpus.begin(), cpus.end(), 0);
    return worst_cases(device(), plan(cell, device()).value(), place(device(), model::Cpus::all(cpus)), runs);
  }
  [[nodiscard]] Problems missed(int number_of_cpus = 2) {
    return missed_deadlines(cell, device(), worst(number_of_cpus));
  }
  /// Returns the worst-case response time of each module, in the order of the descriptor. -1 us means that
  /// the analysis found no bound.
  [[nodiscard]] std::vector<Nanoseconds> responses(int number_of_cpus = 2) {
    std::vector<Nanoseconds> all;
    for (const WorstCase& one : worst(number_of_cpus)) all.push_back(one.response.value_or(-1us));
    return all;
  }

  Cell cell;
  std::vector<std::optional<Nanoseconds>> runs;

 private:
  Module& add(const std::string& name, Nanoseconds run, int executor) {
    Module& module = device().modules.emplace_back();
    module.name = name;
    module.line = static_cast<int>(device().modules.size()) * 10;
    module.executor = device().executors[static_cast<std::size_t>(executor)].name;
    module.priority = static_cast<int>(device().modules.size());
    runs.emplace_back(run);
    return module;
  }
};

Module& process(Module& module) {
  module.type = ModuleType::process;
  return module;
}

// ---- A single executor

TEST(ResponseTimeAnalysis, AddsTheEarlierRunsOfTheSameRow) {
  Cells cells;
  cells.periodic("a", 100us, 20us);
  cells.periodic("b", 100us, 30us);
  EXPECT_THAT(cells.responses(), ElementsAre(20us, 50us));
  EXPECT_THAT(cells.missed(), IsEmpty());
}

TEST(ResponseTimeAnalysis, IsExactToTheNanosecond) {
  Cells cells;
  cells.periodic("a", 100us, 50us);
  cells.periodic("b", 100us, 50us);
  EXPECT_THAT(cells.missed(), IsEmpty());
  cells.runs[1] = 50us + 1ns;
  EXPECT_FALSE(cells.missed().empty());
}

// Times in us: the row at 0 runs a and b until 150. So the row at 100 begins at 150, which is 50 late, and
// ends at 180.
TEST(ResponseTimeAnalysis, AddsTheDelayCausedByALateRow) {
  Cells cells;
  cells.periodic("a", 100us, 30us);
  cells.periodic("b", 200us, 120us);
  EXPECT_THAT(cells.responses(), ElementsAre(80us, 150us));
  EXPECT_THAT(cells.missed(), IsEmpty());
}

// Times in us: the row at 0 runs a and b until 210. So the row at 100 would begin after the end of its slot,
// which is at 200.
TEST(ResponseTimeAnalysis, ReportsAModuleWhoseRowMayBeSkipped) {
  Cells cells;
  cells.periodic("a", 100us, 10us);
  cells.periodic("b", 1ms, 200us);
  EXPECT_THAT(
      cells.missed(),
      ElementsAre(AllOf(Field(&Problem::where, "cell.xml:10"),
                        Field(&Problem::what, HasSubstr("'robot.a' cannot keep its period, 100 us: its "
                                                        "row may begin")))));
}

// With periods of 2 and 3 ms, the row at 1 ms is empty, so the executor may skip it. The row at 0 ms ends at
// 2 ms, the row at 2 ms ends at 2.5 ms, the row at 3 ms ends at 4.5 ms, and the row at 4 ms ends at 5 ms.
TEST(ResponseTimeAnalysis, AllowsAnEmptyRowToBeSkipped) {
  Cells cells;
  cells.periodic("a", 2ms, 500us);
  cells.periodic("b", 3ms, 1500us);
  EXPECT_THAT(cells.responses(), ElementsAre(1ms, 2ms));
  EXPECT_THAT(cells.missed(), IsEmpty());
}

TEST(ResponseTimeAnalysis, FindsNoBoundIfTheWorkExceedsTheAvailableTime) {
  Cells cells;
  cells.periodic("a", 100us, 60us);
  cells.periodic("b", 200us, 90us);
  EXPECT_THAT(cells.responses(), ElementsAre(-1us, -1us));
  EXPECT_THAT(cells.missed()[0].what, HasSubstr("the work does not fit into the available time"));
}

// ---- Executors that share a CPU

TEST(ResponseTimeAnalysis, AddsInterruptionsByAHigherPriorityExecutor) {
  Cells cells{2};
  cells.executor(0).cpu = 1;
  cells.executor(1).cpu = 1;
  cells.periodic("fast", 100us, 30us, 0);
  cells.periodic("slow", 400us, 100us, 1);
  EXPECT_THAT(cells.responses(), ElementsAre(30us, 160us));  // in us: 30 fast + 70 slow + 30 fast + 30 slow
}

// Times in us: the row at 0 of the lower-priority executor waits for module fast, runs a and b, is
// interrupted at 100 and 200, and ends at 250. So the row at 200 of this executor begins at 250 and is
// interrupted at 300, and module a ends at 380.
TEST(ResponseTimeAnalysis, AddsTheDelayOfALateRowToTheNextRowOfALowerPriorityExecutor) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.periodic("fast", 100us, 30us, 0);
  cells.periodic("a", 200us, 100us, 1);
  cells.periodic("b", 400us, 60us, 1);
  EXPECT_THAT(cells.responses(), ElementsAre(30us, 180us, 250us));
}

// Times in us: module fast runs until 90. So the row at 0 of module slow would begin after 50, when the next
// row of slow is due.
TEST(ResponseTimeAnalysis, ReportsARowThatAHigherPriorityExecutorMayDelayTooLong) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.periodic("fast", 400us, 90us, 0);
  cells.periodic("slow", 50us, 1us, 1);
  EXPECT_THAT(cells.missed(),
              ElementsAre(Field(&Problem::what, HasSubstr("its row may begin a whole basic period late"))));
  cells.runs[0] = 40us;
  EXPECT_THAT(cells.missed(), IsEmpty());
}

// The row of module slow ends exactly when the next row of module fast begins. So the executor of slow wakes
// its program only after this row of fast.
TEST(ResponseTimeAnalysis, AddsAnInterruptionJustBeforeAProgramIsWoken) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.periodic("fast", 100us, 30us, 0);
  cells.periodic("slow", 400us, 70us, 1);
  process(cells.periodic("program", 400us, 10us, 1));
  EXPECT_THAT(cells.responses(), ElementsAre(30us, 100us, 140us));
}

TEST(ResponseTimeAnalysis, AddsTheRowsOfExecutorsWithEqualPriority) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.executor(1).priority = cells.executor(0).priority;
  cells.periodic("a", 100us, 30us, 0);
  cells.periodic("b", 100us, 20us, 1);
  EXPECT_THAT(cells.responses(), ElementsAre(50us, 50us));
}

TEST(ResponseTimeAnalysis, TreatsExecutorsOnDifferentCpusIndependently) {
  Cells cells{2};
  cells.periodic("a", 100us, 30us, 0);
  cells.periodic("b", 100us, 20us, 1);
  EXPECT_THAT(cells.responses(3), ElementsAre(30us, 20us));
  EXPECT_THAT(cells.responses(2), ElementsAre(30us, 50us)) << "one CPU is left to the other threads";
}

TEST(ResponseTimeAnalysis, IncludesTheSpinningOfAHigherPriorityExecutor) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.executor(0).wakeup = Wakeup::hybrid;
  cells.executor(0).spin_share = 0.2;
  cells.periodic("fast", 100us, 30us, 0);
  cells.periodic("slow", 400us, 40us, 1);
  EXPECT_THAT(cells.responses(),
              ElementsAre(30us, 90us));  // 20 us of spinning + 30 us of fast + 40 us of slow
}

TEST(ResponseTimeAnalysis, AddsAtMost100MicrosecondsOfSpinning) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.executor(0).wakeup = Wakeup::hybrid;
  cells.periodic("fast", 10ms, 1ms, 0);
  cells.periodic("slow", 40ms, 1ms, 1);
  EXPECT_THAT(cells.responses(), ElementsAre(1ms, 2100us));
}

TEST(ResponseTimeAnalysis, FindsNoBoundForModulesBelowAnExecutorThatNeverSleeps) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.executor(0).wakeup = Wakeup::spin;
  cells.periodic("fast", 100us, 1us, 0);
  cells.sporadic("event", 1ms, 1us, 0);
  cells.periodic("slow", 400us, 1us, 1);
  EXPECT_THAT(cells.responses(), ElementsAre(1us, -1us, -1us));
  EXPECT_THAT(cells.missed(),
              ElementsAre(Field(&Problem::what, HasSubstr("never sleeps leaves it no time on CPU 1")),
                          Field(&Problem::what, HasSubstr("never sleeps"))));
}

// ---- Sporadic modules

TEST(ResponseTimeAnalysis, AddsTheRowsThatInterruptASporadicModule) {
  Cells cells;
  cells.periodic("row", 100us, 30us);
  cells.sporadic("event", 1ms, 100us);
  EXPECT_THAT(cells.responses(), ElementsAre(30us, 160us));
}

TEST(ResponseTimeAnalysis, AddsTheSporadicRunThatIsAlreadyInProgress) {
  Cells cells;
  cells.periodic("row", 1ms, 100us);
  cells.sporadic("urgent", 500us, 100us);
  cells.sporadic("long", 10ms, 200us);
  // Times in us: module long waits for the row (100) and for two runs of urgent (200 in total), and then runs
  // for 200.
  EXPECT_THAT(cells.responses(), ElementsAre(100us, 400us, 500us));
}

TEST(ResponseTimeAnalysis, FindsNoBoundForImmediateDispatchWithoutInterarrivalTime) {
  Cells cells;
  cells.sporadic("event", 1ms, 100us).dispatch = Dispatch::immediate;
  EXPECT_THAT(
      cells.missed(),
      ElementsAre(Problem{"cell.xml:10",
                          "it cannot be shown that 'robot.event' keeps its deadline, 1 ms: the minimum time "
                          "between its releases is not known",
                          "add an <interarrival>"}));
  cells.device().modules[0].interarrival = 200us;
  EXPECT_THAT(cells.responses(), ElementsAre(100us));
}

// ---- Programs

TEST(ResponseTimeAnalysis, StartsAProgramAtTheEndOfItsRow) {
  Cells cells;
  cells.periodic("row", 100us, 30us);
  process(cells.periodic("program", 300us, 50us));
  EXPECT_THAT(cells.responses(2), ElementsAre(30us, 80us));
}

TEST(ResponseTimeAnalysis, AddsTheRowsThatInterruptAProgramOnTheOnlyCpu) {
  Cells cells;
  cells.periodic("row", 100us, 30us);
  process(cells.periodic("program", 300us, 50us));
  // Worst case in us: the row (30), the program (50) and the next row (30).
  EXPECT_THAT(cells.responses(1), ElementsAre(30us, 110us));
}

// With a period of 300 us, a program spins for at most 100 us, or for at most 50 us if two programs share the
// CPU. A program also spins from its release until the end of the row.
TEST(ResponseTimeAnalysis, AddsTheRunTimesOfTheOtherProgramsOfTheSameExecutor) {
  Cells cells;
  cells.periodic("row", 100us, 10us);
  process(cells.periodic("p", 300us, 20us));
  process(cells.periodic("q", 300us, 40us));
  EXPECT_THAT(cells.responses(2), ElementsAre(10us, 10us + 20us, 10us + 40us + 20us + 60us));
}

TEST(ResponseTimeAnalysis, LetsProgramsOfEqualPriorityDelayEachOther) {
  Cells cells;
  cells.periodic("row", 100us, 10us);
  process(cells.periodic("p", 300us, 20us)).priority = 1;
  process(cells.periodic("q", 300us, 40us)).priority = 1;
  const auto responses = cells.responses(2);
  EXPECT_GE(responses[1], 10us + 20us + 40us);
  EXPECT_GE(responses[2], 10us + 40us + 20us);
  EXPECT_THAT(cells.missed(), IsEmpty());
}

TEST(ResponseTimeAnalysis, DividesTheWaitingTimeOfProgramsAmongTheirCpus) {
  Cells cells;
  cells.periodic("row", 1ms, 10us);
  for (const char* name : {"p", "q"}) process(cells.periodic(name, 1ms, 200us));
  const auto worst = cells.worst(3);
  EXPECT_THAT(worst[1].cpus, ElementsAre(0, 1));
  // While the second program waits for a CPU, the first program accounts for at most half of the waiting
  // time.
  EXPECT_LT(*worst[2].response, 10us + 200us + 200us);
  EXPECT_GE(*worst[2].response, 210us);
}

// Two CPUs, three programs: each program may have to wait while the two others occupy both CPUs.
TEST(ResponseTimeAnalysis, AddsProgramsOfEqualPriorityOnSeveralCpus) {
  Cells cells;
  cells.executor().spin_share = 0;
  for (const char* name : {"p", "q", "r"}) process(cells.periodic(name, 1ms, 200us)).priority = 1;
  const auto responses = cells.responses(3);
  for (const Nanoseconds response : responses) {
    EXPECT_GE(response, 400us) << "the other two are released at the same time";
    EXPECT_LE(response, 600us);
  }
}

TEST(ResponseTimeAnalysis, CountsOnlyOneRunOfASporadicProgramThatRunsLongerThanARow) {
  Cells cells;
  cells.periodic("row", 100us, 10us);
  process(cells.sporadic("vision", 10ms, 3ms));
  EXPECT_THAT(cells.responses(2), ElementsAre(10us, 3010us));
}

// A row may release the program of vision again as soon as its body has ended, so this program may never
// sleep.
TEST(ResponseTimeAnalysis, FindsNoBoundIfAProgramOfEqualPriorityMayNeverSleep) {
  Cells cells;
  cells.periodic("row", 100us, 10us);
  process(cells.sporadic("vision", 10ms, 3ms)).priority = 1;
  process(cells.sporadic("radar", 10ms, 1us)).priority = 1;
  EXPECT_THAT(cells.responses(2).back(), -1us);
}

TEST(ResponseTimeAnalysis, FindsNoBoundIfAProgramOfHigherPriorityMayNeverSleep) {
  Cells cells{2};
  cells.periodic("row", 100us, 10us);
  process(cells.sporadic("vision", 10ms, 3ms));
  process(cells.periodic("below", 10ms, 10us, 1));
  EXPECT_THAT(cells.responses(3).back(), -1us);
}

// ---- Messages

TEST(MissedDeadlines, AreReportedWithModuleLineAndLateness) {
  Cells cells;
  cells.periodic("row", 100us, 80us);
  cells.sporadic("event", 150us, 20us);
  EXPECT_THAT(cells.missed(), IsEmpty());
  cells.runs[1] = 40us;
  EXPECT_THAT(
      cells.missed(),
      ElementsAre(Problem{"cell.xml:20",
                          "'robot.event' cannot keep its deadline, 150 us: it may finish as late as 200 us "
                          "after its release, 50 us too late",
                          "shorten the runs, lengthen the deadlines or periods, or move modules to another "
                          "executor or CPU"}));
}

TEST(ResponseTimeAnalysis, OmitsNonRealTimeModules) {
  Cells cells;
  cells.periodic("row", 100us, 80us);
  cells.device().modules.emplace_back().operation = Operation::non_real;
  cells.runs.emplace_back();
  EXPECT_EQ(cells.worst().size(), 1U);
}

}  // namespace
}  // namespace takt::schedule::analysis_test
