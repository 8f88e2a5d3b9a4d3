#include <takt/node/placement.hpp>

#include <gmock/gmock.h>

#include <optional>
#include <string>
#include <vector>

namespace takt::node {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Cpus = std::vector<int>;

model::Executor executor(const std::string& name, std::optional<int> cpu = std::nullopt) {
  model::Executor result;
  result.name = name;
  result.cpu = cpu;
  return result;
}

TEST(Placement, SharesTheOnlyProcessorAndSaysSo) {
  const Placement placement = place({executor("main")}, {0});
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{0}));
  EXPECT_THAT(placement.background, ElementsAre(0));
  EXPECT_THAT(placement.warnings, ElementsAre(HasSubstr("no processor is left")));
}

TEST(Placement, GivesTheHighestOfTwoToTheExecutor) {
  const Placement placement = place({executor("main")}, {0, 1});
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{1}));
  EXPECT_THAT(placement.background, ElementsAre(0));
  EXPECT_THAT(placement.warnings, IsEmpty());
}

TEST(Placement, GivesEachExecutorOneFromTheHighestDown) {
  const Placement placement = place({executor("a"), executor("b")}, {0, 1, 2, 3});
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{3}, Cpus{2}));
  EXPECT_THAT(placement.background, ElementsAre(0, 1));
}

TEST(Placement, LeavesOneToTheOthersWhenThereAreMoreExecutorsThanProcessors) {
  const Placement placement = place({executor("a"), executor("b"), executor("c")}, {0, 1});
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{1}, Cpus{1}, Cpus{1}));
  EXPECT_THAT(placement.background, ElementsAre(0));
}

TEST(Placement, FollowsTheDescriptor) {
  const Placement placement = place({executor("a"), executor("b", 3), executor("c", 0)}, {0, 1, 2, 3});
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{2}, Cpus{3}, Cpus{0}));
  EXPECT_THAT(placement.background, ElementsAre(1));
  EXPECT_THAT(placement.warnings, IsEmpty());
}

TEST(Placement, LetsTwoExecutorsWishForOneProcessor) {
  const Placement placement = place({executor("a", 1), executor("b", 1)}, {0, 1});
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{1}, Cpus{1}));
  EXPECT_THAT(placement.background, ElementsAre(0));
}

TEST(Placement, PlacesAWishThatCannotBeFulfilledAndSaysSo) {
  const Placement placement = place({executor("motion", 5)}, {0, 1});
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{1}));
  EXPECT_THAT(placement.warnings, ElementsAre(AllOf(HasSubstr("motion"), HasSubstr("processor 5"))));
}

TEST(Placement, UsesOnlyWhatIsAllowed) {
  const Placement placement = place({executor("a"), executor("b", 2)}, {4, 7});
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{7}, Cpus{7}));
  EXPECT_THAT(placement.background, ElementsAre(4));
  EXPECT_EQ(placement.warnings.size(), 1U);
}

TEST(Placement, WithAllProcessorsWishedForLeavesTheBackgroundAll) {
  const Placement placement = place({executor("a", 0), executor("b", 1)}, {0, 1});
  EXPECT_THAT(placement.background, ElementsAre(0, 1));
  EXPECT_EQ(placement.warnings.size(), 1U);
}

TEST(Placement, OfNoExecutorLeavesEverything) {
  const Placement placement = place({}, {0, 1});
  EXPECT_THAT(placement.executors, IsEmpty());
  EXPECT_THAT(placement.background, ElementsAre(0, 1));
}

}  // namespace
}  // namespace takt::node
