#include <takt/simulation/random_cell.hpp>

#include <gmock/gmock.h>

namespace takt::simulation {
namespace {

/// Seeds that one test goes through; all together are kSeeds.
constexpr std::uint64_t kSeeds = 2400;
constexpr std::uint64_t kParts = 12;

class RandomCells : public testing::TestWithParam<std::uint64_t> {};

TEST_P(RandomCells, HoldWhatMustHoldWhateverGoesWrong) {
  for (std::uint64_t seed = GetParam(); seed < kSeeds; seed += kParts) {
    const RandomCell random = random_cell(seed);
    const auto course = simulate(random.cell, random.plans, {}, random.options);
    ASSERT_TRUE(course.ok()) << to_text(course.problems());
    ASSERT_THAT(course->violations, testing::IsEmpty())
        << "look at it: takt simulate --random-cell " << seed << " --trace -";
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomCells, testing::Range(std::uint64_t{0}, kParts));

}  // namespace
}  // namespace takt::simulation
