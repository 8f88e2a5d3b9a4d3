#include <takt/schedule/table.hpp>

#include <algorithm>
#include <limits>
#include <optional>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <full_form.hpp>

namespace takt::schedule::table_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr Nanoseconds kLongest = Nanoseconds::max();

std::vector<Table::Index> row(const Table& table, std::size_t index) {
  const auto tasks = table.row(index);
  return {tasks.begin(), tasks.end()};
}

/// Builds the table of these tasks. Returns its only problem, or "accepted" if there is none.
std::string problem_of(const std::vector<Task>& tasks) {
  const auto table = Table::build(tasks);
  if (table) return "accepted";
  EXPECT_EQ(table.problems().size(), 1U);
  EXPECT_FALSE(table.problems().front().fix.empty());
  return table.problems().front().what;
}

// ---- The paper's example, and edge cases

TEST(Table, IsThePapersFigure3ForTheModulesOfFigure1) {
  enum : Table::Index { controller1, control2, control3, control4 };
  const std::vector<Task> tasks{{600us, 3}, {100us, 2}, {100us, 1}, {300us, 4}};
  const auto table = Table::build(tasks);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->basic_period(), 100us);
  EXPECT_EQ(table->macro_period(), 600us);
  ASSERT_EQ(table->rows(), 6U);
  EXPECT_THAT(row(*table, 0), ElementsAre(control3, control2, controller1, control4));
  EXPECT_THAT(row(*table, 1), ElementsAre(control3, control2));
  EXPECT_THAT(row(*table, 2), ElementsAre(control3, control2));
  EXPECT_THAT(row(*table, 3), ElementsAre(control3, control2, control4));
  EXPECT_THAT(row(*table, 4), ElementsAre(control3, control2));
  EXPECT_THAT(row(*table, 5), ElementsAre(control3, control2));
  EXPECT_EQ(table->entries(), 15U);
}

TEST(Table, RejectsPeriodsThatAreNotPositive) {
  const std::vector<Task> tasks{{1ms, 1, "good"}, {0ns, 1, "zero"}, {-1ns, 1}};
  const auto table = Table::build(tasks);
  ASSERT_FALSE(table);
  ASSERT_EQ(table.problems().size(), 2U);
  EXPECT_THAT(table.problems()[0].what, HasSubstr("'zero'"));
  EXPECT_THAT(table.problems()[1].what, HasSubstr("task 2"));
}

TEST(Table, HasNoRowsWithoutTasks) {
  const auto table = Table::build({});
  ASSERT_TRUE(table);
  EXPECT_EQ(table->rows(), 0U);
  EXPECT_EQ(table->entries(), 0U);
  EXPECT_EQ(table->basic_period(), 0ns);
  EXPECT_EQ(table->macro_period(), 0ns);
}

TEST(Table, HasOneRowForOneTaskOfAnyPeriod) {
  for (const Nanoseconds period : {1ns, Nanoseconds{1s}, kLongest}) {
    const std::vector<Task> tasks{{period, 0}};
    const auto table = Table::build(tasks);
    ASSERT_TRUE(table);
    EXPECT_EQ(table->basic_period(), period);
    EXPECT_EQ(table->macro_period(), period);
    ASSERT_EQ(table->rows(), 1U);
    EXPECT_THAT(row(*table, 0), ElementsAre(0U));
  }
}

TEST(Table, HasEmptyRowsIfNothingIsDue) {
  const std::vector<Task> tasks{{2ms, 0}, {3ms, 0}};
  const auto table = Table::build(tasks);
  ASSERT_TRUE(table);
  ASSERT_EQ(table->rows(), 6U);
  EXPECT_THAT(row(*table, 1), IsEmpty());
  EXPECT_THAT(row(*table, 5), IsEmpty());
}

TEST(Table, OrdersTasksByPriorityThenAsInTheInput) {
  const std::vector<Task> tasks{
      {1ms, 5}, {1ms, -3}, {1ms, 5}, {1ms, std::numeric_limits<int>::min()}, {1ms, -3}};
  const auto table = Table::build(tasks);
  ASSERT_TRUE(table);
  EXPECT_THAT(row(*table, 0), ElementsAre(3U, 1U, 4U, 0U, 2U));
}

// ---- Limits

TEST(Table, LimitsTheEntriesOfOneRowToAMillion) {
  std::vector<Task> tasks(kMaxEntries, Task{1ms, 0});
  const auto full = Table::build(tasks);
  ASSERT_TRUE(full);
  EXPECT_EQ(full->rows(), 1U);
  EXPECT_EQ(full->row(0).size(), kMaxEntries);
  EXPECT_EQ(full->row(0).back(), kMaxEntries - 1);

  tasks.push_back({1ms, 0});
  EXPECT_THAT(problem_of(tasks), HasSubstr("1000001 entries"));
}

TEST(Table, LimitsTheEntriesOfAllRowsToAMillion) {
  // The table has 999,999 rows. Each row contains the fast task, and one row also contains the slow task.
  std::vector<Task> tasks{{1us, 0, "fast"}, {1us * 999'999, 0, "slow"}};
  const auto full = Table::build(tasks);
  ASSERT_TRUE(full);
  EXPECT_EQ(full->rows(), 999'999U);
  EXPECT_EQ(full->entries(), kMaxEntries);

  tasks[1].period = 1us * 1'000'000;
  EXPECT_THAT(problem_of(tasks), AllOf(HasSubstr("1000001 entries"), HasSubstr("'fast' with 1 us"),
                                       HasSubstr("'slow' with 1 s")));
}

TEST(Table, LimitsTheRowsToTenMillion) {
  // The table has 78125 x 128 rows and 78125 + 128 entries.
  std::vector<Task> tasks{{78125ns, 0}, {128ns, 0}};  // the periods are 5^7 and 2^7 ns, so a row takes 1 ns
  const auto full = Table::build(tasks);
  ASSERT_TRUE(full);
  EXPECT_EQ(full->rows(), kMaxRows);
  EXPECT_EQ(full->entries(), 78125U + 128U);

  tasks = {{78127ns, 0, "a"}, {128ns, 0, "b"}};
  EXPECT_THAT(problem_of(tasks), AllOf(HasSubstr("10000256 rows"), HasSubstr("'a'"), HasSubstr("'b'")));
}

TEST(Table, RejectsPeriodsWhoseCommonMultipleExceeds64Bits) {
  EXPECT_THAT(
      problem_of({{kLongest, 0, "a"}, {kLongest - 1ns, 0, "b"}}),
      AllOf(HasSubstr("basic period 1 ns"), HasSubstr("macro period more than 10^18 ns"), HasSubstr("'a'"),
            HasSubstr("'b'"), HasSubstr("coincide only once in more than 10^18 ns")));
  // The table would have only six rows, but the macro period would exceed 10^18 ns.
  EXPECT_THAT(problem_of({{Nanoseconds{1LL << 62}, 0}, {Nanoseconds{3LL << 61}, 0}}),
              HasSubstr("more than 10^18 ns"));
}

TEST(Table, RejectsManyPeriodsWhoseCommonMultipleExceeds64Bits) {
  std::vector<Task> tasks;
  for (const int prime : {1009, 1013, 1019, 1021, 1031, 1033, 1039}) tasks.push_back({Nanoseconds{prime}, 0});
  EXPECT_THAT(problem_of(tasks),
              AllOf(HasSubstr("macro period more than 10^18 ns"), HasSubstr("task 6"), HasSubstr("task 5"),
                    HasSubstr("coincide only once in 1073.287 us"), Not(HasSubstr("once in more than"))));
}

TEST(Table, NamesThePairOfPeriodsThatMakesTheTableLong) {
  // All periods except 7.001 ms are multiples of each other.
  const std::string what =
      problem_of({{1ms, 0, "servo"}, {4ms, 0, "plan"}, {7001us, 0, "camera"}, {1s, 0, "log"}});
  EXPECT_THAT(what, HasSubstr("'camera' with 7.001 ms and 'log' with 1 s coincide only once in 7001 s"));
}

/// Returns how to correct tasks whose table is too large.
std::string fix_of(const std::vector<Task>& tasks) {
  const auto table = Table::build(tasks);
  return table ? "none needed" : table.problems().at(0).fix;
}

TEST(Table, ProposesAPeriodWithWhichItIsSmallEnough) {
  EXPECT_EQ(fix_of({{1ms, 0, "servo"}, {4ms, 0, "plan"}, {16'666'667ns, 0, "screen"}}),
            "give 'screen' a period of 17 ms, or give each module its own executor");
  EXPECT_EQ(fix_of({{600ms, 0, "slow"}, {333'333ns, 0, "fast"}}),
            "give 'fast' a period of 330 us, or give each module its own executor");
}

TEST(Table, ProposesNoPeriodIfItIsTooLargeWithEachOfThem) {
  EXPECT_EQ(fix_of({{1s, 0, "a"}, {1'300'000'001ns, 0, "b"}, {1'700'000'003ns, 0, "c"}}),
            "choose periods that are multiples of each other, or give each module its own executor");
}

TEST(LongestPeriodPair, PrefersTheShortestPeriodIfPairsAreEquallyLong) {
  const std::vector<Task> tasks{{2us, 0}, {1us, 0}, {1us, 0}, {10s, 0}, {5s, 0}};
  const PeriodPair pair = longest_pair(tasks);
  EXPECT_EQ(pair.shorter, 1U);
  EXPECT_EQ(pair.longer, 3U);
}

TEST(LongestPeriodPair, IsASingleTaskIfAllPeriodsAreEqual) {
  const std::vector<Task> tasks{{2us, 0}, {2us, 0}};
  const PeriodPair pair = longest_pair(tasks);
  EXPECT_EQ(pair.shorter, pair.longer);
}

// ---- Comparison with a naive implementation

/// The expected result of Table::build(), computed directly from the definition.
struct Naive {
  __extension__ using Wide = __int128;
  static constexpr Wide kTooLong = std::numeric_limits<std::int64_t>::max();

  static std::int64_t common_divisor(std::int64_t a, std::int64_t b) {
    while (b != 0) {
      const std::int64_t rest = a - a / b * b;
      a = b;
      b = rest;
    }
    return a;
  }

  explicit Naive(const std::vector<Task>& tasks) {
    basic = tasks.front().period.count();
    macro = 1;
    for (const Task& task : tasks) {
      const std::int64_t period = task.period.count();
      basic = common_divisor(basic, period);
      if (macro <= kTooLong)
        macro = macro / common_divisor(static_cast<std::int64_t>(macro), period) * period;
    }
    accepted = macro <= kTooLong;
    if (!accepted) return;
    for (const Task& task : tasks) entries += macro / task.period.count();
    accepted = entries <= 1'000'000 && macro / basic <= 10'000'000;
  }

  /// Returns the indices of the tasks that are due at time `t`, in the order in which they run.
  static std::vector<Table::Index> due(const std::vector<Task>& tasks, std::int64_t t) {
    std::vector<Table::Index> found;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      if (t % tasks[i].period.count() == 0) found.push_back(static_cast<Table::Index>(i));
    }
    std::stable_sort(found.begin(), found.end(),
                     [&](auto a, auto b) { return tasks[a].priority < tasks[b].priority; });
    return found;
  }

  std::int64_t basic = 0;
  Wide macro = 0;
  Wide entries = 0;
  bool accepted = false;
};

/// Compares the rows of the table of these tasks with the definition. If comparing all rows would take more
/// than `work` steps, compares only evenly spaced rows and the last row.
void expect_as_defined(const std::vector<Task>& tasks, std::size_t work) {
  const Naive naive{tasks};
  const auto table = Table::build(tasks);
  ASSERT_EQ(table.ok(), naive.accepted);
  if (!naive.accepted) return;

  ASSERT_EQ(table->basic_period().count(), naive.basic);
  ASSERT_EQ(table->macro_period().count(), static_cast<std::int64_t>(naive.macro));
  ASSERT_EQ(table->rows(), static_cast<std::size_t>(naive.macro / naive.basic));
  ASSERT_EQ(table->entries(), static_cast<std::size_t>(naive.entries));
  const std::size_t rows = table->rows();
  const std::size_t step = std::max<std::size_t>(1, rows * tasks.size() / work);
  for (std::size_t i = 0; i < rows; i += step) {
    ASSERT_EQ(row(*table, i), Naive::due(tasks, static_cast<std::int64_t>(i) * naive.basic)) << "row " << i;
  }
  ASSERT_EQ(row(*table, rows - 1), Naive::due(tasks, static_cast<std::int64_t>(rows - 1) * naive.basic));
}

/// Draws random sets of tasks of four kinds. Many sets are within the limits of a table, many exceed the
/// limits by far, and some are close to them.
class ModuleSets {
 public:
  std::vector<Task> draw() {
    const std::int64_t family = between(0, 3);
    // Half of the sets have at most 12 tasks, and the other half at most 1000.
    const std::int64_t count = between(1, between(0, 1) == 0 ? 12 : 1000);
    const std::int64_t unit = between(1, 20) * power_of_ten(between(3, 5));
    std::vector<Task> tasks;
    for (std::int64_t i = 0; i < count; ++i) {
      tasks.push_back({bounded(period(family, unit)), static_cast<int>(between(-3, 20))});
    }
    return tasks;
  }

 private:
  std::int64_t between(std::int64_t low, std::int64_t high) {
    return std::uniform_int_distribution<std::int64_t>{low, high}(random_);
  }

  static std::int64_t power_of_ten(std::int64_t exponent) {
    std::int64_t value = 1;
    while (exponent-- > 0) value *= 10;
    return value;
  }

  static Nanoseconds bounded(std::int64_t ns) {
    return Nanoseconds{std::clamp<std::int64_t>(ns, 1'000, 10'000'000'000)};
  }

  std::int64_t period(std::int64_t family, std::int64_t unit) {
    switch (family) {
      case 0: {  // typical periods: 1, 2 or 5 times a power of ten
        constexpr std::array<std::int64_t, 3> kSteps{1, 2, 5};
        return kSteps[static_cast<std::size_t>(between(0, 2))] * power_of_ten(between(5, 8));
      }
      case 1: {  // divisors of 720 units
        std::int64_t divisor = between(1, 720);
        while (720 % divisor != 0) ++divisor;
        return divisor * unit;
      }
      case 2:
        return between(1, 14) * unit;  // multiples of one unit
      default:
        return between(1'000, 10'000'000'000);
    }
  }

  std::mt19937_64 random_{20240607};
};

TEST(Table, MatchesItsDefinitionForRandomSetsOfModules) {
  ModuleSets sets;
  int accepted = 0;
  int rejected = 0;
  const int count = how_often(4000);
  for (int i = 0; i < count; ++i) {
    const auto tasks = sets.draw();
    ASSERT_NO_FATAL_FAILURE(expect_as_defined(tasks, 500'000)) << "set " << i;
    (Table::build(tasks).ok() ? accepted : rejected)++;
  }
  EXPECT_GT(accepted, count / 4);
  EXPECT_GT(rejected, count / 4);
  RecordProperty("accepted", accepted);
  RecordProperty("rejected", rejected);
}

TEST(LongestPeriodPair, MatchesItsDefinitionForRandomSetsOfModules) {
  ModuleSets sets;
  for (int i = 0; i < 300; ++i) {
    const auto tasks = sets.draw();
    Naive::Wide largest = 0;
    Nanoseconds shortest{};
    for (const Task& a : tasks) {
      for (const Task& b : tasks) {
        if (a.period >= b.period) continue;
        const std::int64_t divisor = Naive::common_divisor(b.period.count(), a.period.count());
        const Naive::Wide multiple = Naive::Wide{b.period.count() / divisor} * a.period.count();
        if (multiple > largest || (multiple == largest && a.period < shortest)) shortest = a.period;
        largest = std::max(largest, multiple);
      }
    }
    const PeriodPair pair = longest_pair(tasks);
    if (largest == 0) {
      ASSERT_EQ(pair.shorter, pair.longer);
      continue;
    }
    const std::int64_t low = tasks[pair.shorter].period.count();
    const std::int64_t high = tasks[pair.longer].period.count();
    ASSERT_LT(low, high);
    ASSERT_EQ(low, shortest.count());
    ASSERT_TRUE(Naive::Wide{high / Naive::common_divisor(high, low)} * low == largest);
  }
}

}  // namespace
}  // namespace takt::schedule::table_test
