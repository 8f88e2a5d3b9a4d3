#include "offsets.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <random>

namespace takt::schedule::offsets_test {
namespace {

using namespace std::chrono_literals;
using testing::Each;
using testing::ElementsAre;
using testing::IsEmpty;

/// Returns the weight of the fullest row. Follows the definition: checks each module in each row of the macro
/// period.
std::int64_t fullest(const std::vector<Shiftable>& modules, const std::vector<Nanoseconds>& offsets) {
  std::int64_t basic = 0;
  std::int64_t macro = 1;
  for (std::size_t i = 0; i < modules.size(); ++i) {
    basic = std::gcd(std::gcd(basic, modules[i].period.count()), offsets[i].count());
    macro = std::lcm(macro, modules[i].period.count());
  }
  std::int64_t most = 0;
  for (std::int64_t at = 0; at < macro; at += basic) {
    std::int64_t row = 0;
    for (std::size_t i = 0; i < modules.size(); ++i) {
      if ((at - offsets[i].count() + macro) % modules[i].period.count() == 0) row += modules[i].weight;
    }
    most = std::max(most, row);
  }
  return most;
}

std::vector<Nanoseconds> unshifted(const std::vector<Shiftable>& modules) {
  std::vector<Nanoseconds> offsets;
  for (const Shiftable& module : modules) offsets.push_back(module.fixed ? module.offset : 0ns);
  return offsets;
}

/// Tries all combinations of offsets from module `i` on. Returns the smallest weight that the fullest row can
/// have.
std::int64_t lightest(const std::vector<Shiftable>& modules, std::vector<Nanoseconds>& offsets, std::size_t i,
                      Nanoseconds basic) {
  if (i == modules.size()) return fullest(modules, offsets);
  if (modules[i].fixed) return lightest(modules, offsets, i + 1, basic);
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (Nanoseconds offset{0}; offset < modules[i].period; offset += basic) {
    offsets[i] = offset;
    least = std::min(least, lightest(modules, offsets, i + 1, basic));
  }
  offsets[i] = 0ns;
  return least;
}

TEST(Offsets, ReduceTheFullestRowOfThePapersFigure1FromFourRunsToThree) {
  // Modules controller1 to controller4 have periods of 600, 100, 100 and 300 us.
  const std::vector<Shiftable> modules{
      {.period = 600us}, {.period = 100us}, {.period = 100us}, {.period = 300us}};
  EXPECT_EQ(fullest(modules, unshifted(modules)), 4);
  const auto offsets = flatten(modules);
  EXPECT_EQ(fullest(modules, offsets), 3);
  for (std::size_t i = 0; i < modules.size(); ++i) {
    EXPECT_LT(offsets[i], modules[i].period);
    EXPECT_EQ(offsets[i] % 100us, 0ns) << "the basic period does not change";
  }
}

TEST(Offsets, KeepTheOffsetsGivenInTheDescriptor) {
  const std::vector<Shiftable> modules{{.period = 4ms, .offset = 3ms, .fixed = true}, {.period = 4ms}};
  const auto offsets = flatten(modules);
  EXPECT_EQ(offsets[0], 3ms);
  EXPECT_NE(offsets[1], 3ms);
  EXPECT_EQ(fullest(modules, offsets), 1);
}

TEST(Offsets, BalanceTheWorkOfTheRows) {
  const std::vector<Shiftable> modules{{.period = 2ms, .weight = 90},
                                       {.period = 2ms, .weight = 50},
                                       {.period = 2ms, .weight = 40},
                                       {.period = 1ms, .weight = 1}};
  EXPECT_EQ(fullest(modules, flatten(modules)), 91) << "50 and 40 share a row, and 90 has its own";
}

TEST(Offsets, NeverShortenTheBasicPeriod) {
  const std::vector<Shiftable> modules{{.period = 2ms}, {.period = 2ms}};
  EXPECT_THAT(flatten(modules), Each(0ns))
      << "an offset of half the period would separate them, but double the rows";
}

TEST(Offsets, AreEmptyWithoutModules) { EXPECT_THAT(flatten({}), IsEmpty()); }

TEST(Offsets, AreZeroIfTheyWouldNotReduceTheFullestRow) {
  const std::vector<Shiftable> modules{{.period = 1ms}, {.period = 1ms}};
  EXPECT_THAT(flatten(modules), Each(0ns));
}

TEST(Offsets, AreOptimalForSmallTables) {
  std::mt19937 random{11};
  const std::vector<std::int64_t> periods{1, 2, 3, 4, 6};
  int lighter = 0;
  for (int set = 0; set < 400; ++set) {
    std::vector<Shiftable> modules(1 + random() % 5);
    std::int64_t basic = 0;
    for (Shiftable& module : modules) {
      module.period = 1ms * periods[random() % periods.size()];
      module.weight = 1 + static_cast<std::int64_t>(random() % 9);
      module.fixed = random() % 6 == 0;
      if (module.fixed) module.offset = 1ms * (static_cast<std::int64_t>(random()) % (module.period / 1ms));
      basic = std::gcd(std::gcd(basic, module.period.count()), module.offset.count());
    }
    const auto offsets = flatten(modules);
    auto tried = unshifted(modules);
    const std::int64_t best = lightest(modules, tried, 0, Nanoseconds{basic});
    ASSERT_EQ(fullest(modules, offsets), best) << "set " << set;
    ASSERT_EQ(offsets, flatten(modules)) << "the same input gives the same result";
    lighter += best < fullest(modules, unshifted(modules)) ? 1 : 0;
  }
  EXPECT_GT(lighter, 50);
}

TEST(Offsets, AtLeastHalveTheFullestRowOfManyModules) {
  std::mt19937 random{12};
  const std::vector<std::int64_t> periods{1, 2, 4, 5, 8, 10, 20, 40, 50, 100};
  for (const std::size_t count : {30U, 300U, 10'000U}) {
    std::vector<Shiftable> modules(count);
    std::int64_t load = 0;
    for (Shiftable& module : modules) {
      module.period = 1ms * periods[random() % periods.size()];
      module.weight = 1 + static_cast<std::int64_t>(random() % 1000);
      load += module.weight * (200ms / module.period);
    }
    const auto begin = std::chrono::steady_clock::now();
    const auto offsets = flatten(modules);
    const auto took = std::chrono::steady_clock::now() - begin;
    EXPECT_LT(took, 10s) << "the search takes too long";
    // With so many modules, fullest() would take too long.
    if (count == 10'000U) continue;
    const std::int64_t most = fullest(modules, offsets);
    EXPECT_LT(most, fullest(modules, unshifted(modules)) / 2);
    EXPECT_LE(most, load / 200 + 1000) << count << ": above the mean by at most the weight of one module";
  }
}

TEST(Offsets, CanBeComputedFor200000ModulesWithoutExhaustingTheStack) {
  std::vector<Shiftable> modules(200'000, {.period = 2ms, .weight = 1});
  modules.push_back({.period = 1ms, .weight = 1});
  EXPECT_EQ(fullest(modules, flatten(modules)), 100'001);
}

TEST(Offsets, AreZeroIfTheTableIsTooLongToSearch) {
  const std::vector<Shiftable> modules{{.period = 999'983ns}, {.period = 1'000'003ns}};
  EXPECT_THAT(flatten(modules), ElementsAre(0ns, 0ns));
}

}  // namespace
}  // namespace takt::schedule::offsets_test
