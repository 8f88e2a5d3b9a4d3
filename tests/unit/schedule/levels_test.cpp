#include <takt/schedule/levels.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace takt::schedule::levels_test {
namespace {

using model::ModuleType;
using model::Operation;
using testing::Each;
using testing::ElementsAre;

/// A device with one executor, to which these modules belong.
struct Sample {
  explicit Sample(int priority = 80) { device.executors.emplace_back().priority = priority; }

  void add(Operation operation, int priority, ModuleType type = ModuleType::process) {
    model::Module& module = device.modules.emplace_back();
    module.name = "m" + std::to_string(device.modules.size());
    module.executor = device.executors[0].name;
    module.type = type;
    module.operation = operation;
    module.priority = priority;
    (operation == Operation::periodic ? module.period : module.deadline) = std::chrono::milliseconds{1};
  }
  /// Returns the level of each program, in the order of the descriptor.
  [[nodiscard]] std::vector<int> levels() const {
    const DevicePlan plan = schedule::plan(model::Cell{}, device).value();
    std::vector<int> all;
    for (std::uint32_t i = 0; i < device.modules.size(); ++i) {
      if (device.modules[i].type == ModuleType::process)
        all.push_back(program_level(device, plan.executors[0], i));
    }
    return all;
  }

  model::Device device;
};

TEST(Levels, FollowThePrioritiesOfThePrograms) {
  Sample sample;
  for (const int priority : {9, 1, 5}) sample.add(Operation::periodic, priority);
  EXPECT_THAT(sample.levels(), ElementsAre(77, 79, 78));
}

TEST(Levels, AreEqualForEqualPriorities) {
  Sample sample;
  for (const int priority : {2, 1, 2}) sample.add(Operation::periodic, priority);
  EXPECT_THAT(sample.levels(), ElementsAre(78, 79, 78));
}

TEST(Levels, DoNotDependOnThreadModules) {
  Sample sample;
  sample.add(Operation::periodic, 1, ModuleType::thread);
  sample.add(Operation::periodic, 2);
  EXPECT_THAT(sample.levels(), ElementsAre(79));
}

TEST(Levels, AreSharedByAdjacentPrioritiesIfThereAreTooFewLevels) {
  Sample sample;
  for (int priority = 1; priority <= 7; ++priority) sample.add(Operation::periodic, priority);
  EXPECT_THAT(sample.levels(), ElementsAre(79, 79, 78, 77, 77, 76, 75));
}

TEST(Levels, AreLowerForSporadicModulesThanForPeriodicPrograms) {
  Sample sample;
  for (int priority = 1; priority <= 5; ++priority) sample.add(Operation::periodic, priority);
  for (int priority = 1; priority <= 3; ++priority) sample.add(Operation::sporadic, priority);
  EXPECT_THAT(sample.levels(), ElementsAre(79, 78, 77, 76, 75, 73, 72, 71));
  EXPECT_EQ(sporadic_level(80), 74);
}

TEST(Levels, AreNeverBelowOne) {
  Sample sample{2};
  sample.add(Operation::periodic, 1);
  sample.add(Operation::periodic, 2);
  sample.add(Operation::sporadic, 1);
  EXPECT_THAT(sample.levels(), Each(1));
  EXPECT_EQ(sporadic_level(2), 1);
}

}  // namespace
}  // namespace takt::schedule::levels_test
