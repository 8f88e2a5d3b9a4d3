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

/// Modules with their longest run, on executors that only sleep, so that what is expected can be worked out.
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

  [[nodiscard]] std::vector<WorstCase> worst(int processors = 2) {
    std::vector<int> cpus(static_cast<std::size_t>(processors));
    std::iota(cpus.begin(), cpus.end(), 0);
    return worst_cases(device(), plan(cell, device()).value(), place(device().executors, cpus), runs);
  }
  [[nodiscard]] Problems missed(int processors = 2) {
    return missed_deadlines(cell, device(), worst(processors));
  }
  /// The response of each module, in the order of the file; -1 us: no bound.
  [[nodiscard]] std::vector<Nanoseconds> responses(int processors = 2) {
    std::vector<Nanoseconds> all;
    for (const WorstCase& one : worst(processors)) all.push_back(one.response.value_or(-1us));
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

// ---- one executor, alone

TEST(WorstCase, OfARowIsTheSumOfThoseBefore) {
  Cells cells;
  cells.periodic("a", 100us, 20us);
  cells.periodic("b", 100us, 30us);
  EXPECT_THAT(cells.responses(), ElementsAre(20us, 50us));
  EXPECT_THAT(cells.missed(), IsEmpty());
}

TEST(WorstCase, IsKeptToTheNanosecond) {
  Cells cells;
  cells.periodic("a", 100us, 50us);
  cells.periodic("b", 100us, 50us);
  EXPECT_THAT(cells.missed(), IsEmpty());
  cells.runs[1] = 50us + 1ns;
  EXPECT_FALSE(cells.missed().empty());
}

// 0: a b, to 150, late by 50. 100: begins at 150, to 180. 200: to 230 ...
TEST(WorstCase, CarriesALateRowOverToTheNext) {
  Cells cells;
  cells.periodic("a", 100us, 30us);
  cells.periodic("b", 200us, 120us);
  EXPECT_THAT(cells.responses(), ElementsAre(80us, 150us));
  EXPECT_THAT(cells.missed(), IsEmpty());
}

// 0: a b, to 210. The row of 100 would begin when it is over.
TEST(WorstCase, SaysThatARowIsSkipped) {
  Cells cells;
  cells.periodic("a", 100us, 10us);
  cells.periodic("b", 1ms, 200us);
  EXPECT_THAT(
      cells.missed(),
      ElementsAre(AllOf(Field(&Problem::where, "cell.xml:10"),
                        Field(&Problem::what, HasSubstr("'robot.a' cannot keep its period, 100 us: its "
                                                        "row may begin")))));
}

// Periods 2 and 3: row 1 is empty, and skipped without harm. 0: to 2. 2: to 2.5. 3: to 4.5. 4: to 5.
TEST(WorstCase, OfAnEmptyRowThatIsSkippedHarmsNobody) {
  Cells cells;
  cells.periodic("a", 2ms, 500us);
  cells.periodic("b", 3ms, 1500us);
  EXPECT_THAT(cells.responses(), ElementsAre(1ms, 2ms));
  EXPECT_THAT(cells.missed(), IsEmpty());
}

TEST(WorstCase, HasNoBoundWhereThereIsMoreToDoThanTime) {
  Cells cells;
  cells.periodic("a", 100us, 60us);
  cells.periodic("b", 200us, 90us);
  EXPECT_THAT(cells.responses(), ElementsAre(-1us, -1us));
  EXPECT_THAT(cells.missed()[0].what, HasSubstr("more to do than there is time for"));
}

// ---- executors that share a processor

TEST(WorstCase, OfALowerExecutorIncludesTheRowsThatInterruptIt) {
  Cells cells{2};
  cells.executor(0).cpu = 1;
  cells.executor(1).cpu = 1;
  cells.periodic("fast", 100us, 30us, 0);
  cells.periodic("slow", 400us, 100us, 1);
  EXPECT_THAT(cells.responses(), ElementsAre(30us, 160us));  // 30 + 70 + 30 + 30
}

// 0: fast, a, b, interrupted at 100 and 200, to 250. 200: a waits until then, and for the row of 300, to 380.
TEST(WorstCase, OfALowerExecutorCarriesALateRowOver) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.periodic("fast", 100us, 30us, 0);
  cells.periodic("a", 200us, 100us, 1);
  cells.periodic("b", 400us, 60us, 1);
  EXPECT_THAT(cells.responses(), ElementsAre(30us, 180us, 250us));
}

// 0: fast to 90. The row of 0 would begin when that of 50 is due.
TEST(WorstCase, OfALowerExecutorKnowsThatARowIsSkipped) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.periodic("fast", 400us, 90us, 0);
  cells.periodic("slow", 50us, 1us, 1);
  EXPECT_THAT(cells.missed(),
              ElementsAre(Field(&Problem::what, HasSubstr("its row may begin a whole basic period late"))));
  cells.runs[0] = 40us;
  EXPECT_THAT(cells.missed(), IsEmpty());
}

// The row of slow is over when the next one of fast begins, and only after that does its program hear of it.
TEST(WorstCase, OfAProgramWaitsForARowThatIsInterruptedAtItsEnd) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.periodic("fast", 100us, 30us, 0);
  cells.periodic("slow", 400us, 70us, 1);
  process(cells.periodic("program", 400us, 10us, 1));
  EXPECT_THAT(cells.responses(), ElementsAre(30us, 100us, 140us));
}

TEST(WorstCase, OfExecutorsOfOnePriorityIncludesTheOther) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.executor(1).priority = cells.executor(0).priority;
  cells.periodic("a", 100us, 30us, 0);
  cells.periodic("b", 100us, 20us, 1);
  EXPECT_THAT(cells.responses(), ElementsAre(50us, 50us));
}

TEST(WorstCase, IsEachItsOwnOnProcessorsOfTheirOwn) {
  Cells cells{2};
  cells.periodic("a", 100us, 30us, 0);
  cells.periodic("b", 100us, 20us, 1);
  EXPECT_THAT(cells.responses(3), ElementsAre(30us, 20us));
  EXPECT_THAT(cells.responses(2), ElementsAre(30us, 50us)) << "one is left to everything else";
}

TEST(WorstCase, OfALowerExecutorIncludesTheSpinningOfTheOther) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.executor(0).wakeup = Wakeup::hybrid;
  cells.executor(0).spin_share = 0.2;
  cells.periodic("fast", 100us, 30us, 0);
  cells.periodic("slow", 400us, 40us, 1);
  EXPECT_THAT(cells.responses(), ElementsAre(30us, 90us));  // 20 spun, 30, 40
}

TEST(WorstCase, SpinsForAHundredMicrosecondsAtMost) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.executor(0).wakeup = Wakeup::hybrid;
  cells.periodic("fast", 10ms, 1ms, 0);
  cells.periodic("slow", 40ms, 1ms, 1);
  EXPECT_THAT(cells.responses(), ElementsAre(1ms, 2100us));
}

TEST(WorstCase, BelowAnExecutorThatNeverSleepsIsNever) {
  Cells cells{2};
  cells.executor(0).cpu = cells.executor(1).cpu = 1;
  cells.executor(0).wakeup = Wakeup::spin;
  cells.periodic("fast", 100us, 1us, 0);
  cells.sporadic("event", 1ms, 1us, 0);
  cells.periodic("slow", 400us, 1us, 1);
  EXPECT_THAT(cells.responses(), ElementsAre(1us, -1us, -1us));
  EXPECT_THAT(cells.missed(),
              ElementsAre(Field(&Problem::what, HasSubstr("never sleeps leaves it no time on processor 1")),
                          Field(&Problem::what, HasSubstr("never sleeps"))));
}

// ---- sporadic modules

TEST(WorstCase, OfASporadicModuleIncludesTheRowsThatInterruptIt) {
  Cells cells;
  cells.periodic("row", 100us, 30us);
  cells.sporadic("event", 1ms, 100us);
  EXPECT_THAT(cells.responses(), ElementsAre(30us, 160us));
}

TEST(WorstCase, OfASporadicModuleWaitsForTheOneThatRuns) {
  Cells cells;
  cells.periodic("row", 1ms, 100us);
  cells.sporadic("urgent", 500us, 100us);
  cells.sporadic("long", 10ms, 200us);
  EXPECT_THAT(cells.responses(), ElementsAre(100us, 400us, 500us));  // the last: 100, urgent twice, 200
}

TEST(WorstCase, OfAModuleWithoutInterarrivalThatIsDispatchedAtOnceHasNoBound) {
  Cells cells;
  cells.sporadic("event", 1ms, 100us).dispatch = Dispatch::immediate;
  EXPECT_THAT(cells.missed(), ElementsAre(Field(&Problem::fix, "an <interarrival>")));
  cells.device().modules[0].interarrival = 200us;
  EXPECT_THAT(cells.responses(), ElementsAre(100us));
}

// ---- programs

TEST(WorstCase, OfAProgramBeginsWhenItsRowEnds) {
  Cells cells;
  cells.periodic("row", 100us, 30us);
  process(cells.periodic("program", 300us, 50us));
  EXPECT_THAT(cells.responses(2), ElementsAre(30us, 80us));
}

TEST(WorstCase, OfTheOnlyProgramOnOneProcessorIncludesTheRows) {
  Cells cells;
  cells.periodic("row", 100us, 30us);
  process(cells.periodic("program", 300us, 50us));
  EXPECT_THAT(cells.responses(1), ElementsAre(30us, 110us));  // 30 from its release; 30 + 50
}

// Of 300 us each spins 100 at most, two of them half of that; and after the release until its row is over.
TEST(WorstCase, OfProgramsOfOneExecutorLetEachGoFirst) {
  Cells cells;
  cells.periodic("row", 100us, 10us);
  process(cells.periodic("p", 300us, 20us));
  process(cells.periodic("q", 300us, 40us));
  EXPECT_THAT(cells.responses(2), ElementsAre(10us, 10us + 20us + 40us + 60us, 10us + 40us + 20us + 60us));
}

TEST(WorstCase, OfProgramsOnSeveralProcessorsIsShared) {
  Cells cells;
  cells.periodic("row", 1ms, 10us);
  for (const char* name : {"p", "q"}) process(cells.periodic(name, 1ms, 200us));
  const auto worst = cells.worst(3);
  EXPECT_THAT(worst[1].cpus, ElementsAre(0, 1));
  // The other one takes at most half of the time in which this one waits.
  EXPECT_LT(*worst[1].response, 10us + 200us + 200us);
  EXPECT_GE(*worst[1].response, 210us);
}

// Three on two processors, which they share with nobody: two may keep this one waiting, for as long as they
// take both.
TEST(WorstCase, OfProgramsOnSeveralProcessorsIncludesEquals) {
  Cells cells;
  cells.executor().spin_share = 0;
  for (const char* name : {"p", "q", "r"}) process(cells.periodic(name, 1ms, 200us));
  const auto responses = cells.responses(3);
  for (const Nanoseconds response : responses) {
    EXPECT_GE(response, 400us) << "the other two are there at once";
    EXPECT_LE(response, 600us);
  }
}

TEST(WorstCase, OfASporadicProgramThatRunsLongerThanARowIsItsOwn) {
  Cells cells;
  cells.periodic("row", 100us, 10us);
  process(cells.sporadic("vision", 10ms, 3ms));
  EXPECT_THAT(cells.responses(2), ElementsAre(10us, 3010us));
}

// Released again by the row that comes just when it is done, the other one need never sleep.
TEST(WorstCase, BesideAnEqualProgramThatMayAlwaysRunHasNoBound) {
  Cells cells;
  cells.periodic("row", 100us, 10us);
  process(cells.sporadic("vision", 10ms, 3ms));
  process(cells.sporadic("radar", 10ms, 1us));
  EXPECT_THAT(cells.responses(2).back(), -1us);
}

TEST(WorstCase, BelowAProgramThatMayAlwaysRunHasNoBound) {
  Cells cells{2};
  cells.periodic("row", 100us, 10us);
  process(cells.sporadic("vision", 10ms, 3ms));
  process(cells.periodic("below", 10ms, 10us, 1));
  EXPECT_THAT(cells.responses(3).back(), -1us);
}

// ---- what is said

TEST(MissedDeadlines, NamesTheModuleItsLineAndByHowMuch) {
  Cells cells;
  cells.periodic("row", 100us, 80us);
  cells.sporadic("event", 150us, 20us);
  EXPECT_THAT(cells.missed(), IsEmpty());
  cells.runs[1] = 40us;
  EXPECT_THAT(
      cells.missed(),
      ElementsAre(Problem{"cell.xml:20",
                          "'robot.event' cannot keep its deadline, 150 us: it may be done only 200 us after "
                          "its release, 50 us late",
                          "shorter runs, longer deadlines or periods, or modules moved to another executor "
                          "or processor"}));
}

TEST(WorstCase, LeavesOutWhatIsNotRealTime) {
  Cells cells;
  cells.periodic("row", 100us, 80us);
  cells.device().modules.emplace_back().operation = Operation::non_real;
  cells.runs.emplace_back();
  EXPECT_EQ(cells.worst().size(), 1U);
}

}  // namespace
}  // namespace takt::schedule::analysis_test
