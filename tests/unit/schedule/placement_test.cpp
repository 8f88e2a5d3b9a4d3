#include <takt/schedule/placement.hpp>

#include <gmock/gmock.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace takt::schedule::placement_test {
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

/// A device with these executors and one process module.
model::Device with(std::vector<model::Executor> executors) {
  model::Device device;
  device.executors = std::move(executors);
  device.modules.emplace_back().type = model::ModuleType::process;
  return device;
}

TEST(Placement, DoesNotWarnADeviceWithoutProcessModules) {
  model::Device device = with({executor("main")});
  device.modules[0].type = model::ModuleType::thread;
  EXPECT_THAT(place(device, model::Cpus::all({0})).warnings, IsEmpty());
}

TEST(Placement, WarnsThatProcessModulesShareTheOnlyCpu) {
  const Placement placement = place(with({executor("main")}), model::Cpus::all({0}));
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{0}));
  EXPECT_THAT(placement.background, ElementsAre(0));
  EXPECT_THAT(placement.warnings, ElementsAre(HasSubstr("no CPU is left")));
}

TEST(Placement, GivesTheExecutorTheHigherNumberedOfTwoCpus) {
  const Placement placement = place(with({executor("main")}), model::Cpus::all({0, 1}));
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{1}));
  EXPECT_THAT(placement.background, ElementsAre(0));
  EXPECT_THAT(placement.warnings, IsEmpty());
}

TEST(Placement, GivesEachExecutorItsOwnCpuFromTheHighestNumberDown) {
  const Placement placement = place(with({executor("a"), executor("b")}), model::Cpus::all({0, 1, 2, 3}));
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{3}, Cpus{2}));
  EXPECT_THAT(placement.background, ElementsAre(0, 1));
}

TEST(Placement, LeavesACpuToOtherThreadsIfThereAreTooManyExecutors) {
  const Placement placement =
      place(with({executor("a"), executor("b"), executor("c")}), model::Cpus::all({0, 1}));
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{1}, Cpus{1}, Cpus{1}));
  EXPECT_THAT(placement.background, ElementsAre(0));
}

TEST(Placement, UsesTheCpusOfTheDescriptor) {
  const Placement placement =
      place(with({executor("a"), executor("b", 3), executor("c", 0)}), model::Cpus::all({0, 1, 2, 3}));
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{2}, Cpus{3}, Cpus{0}));
  EXPECT_THAT(placement.background, ElementsAre(1));
  EXPECT_THAT(placement.warnings, IsEmpty());
}

TEST(Placement, AllowsTwoExecutorsToRequestTheSameCpu) {
  const Placement placement = place(with({executor("a", 1), executor("b", 1)}), model::Cpus::all({0, 1}));
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{1}, Cpus{1}));
  EXPECT_THAT(placement.background, ElementsAre(0));
}

TEST(Placement, WarnsAndUsesAnotherCpuIfTheRequestedOneIsMissing) {
  model::Executor motion = executor("motion", 5);
  motion.line = 7;
  const Placement placement = place(with({motion}), model::Cpus::all({0, 1}));
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{1}));
  EXPECT_THAT(placement.warnings, ElementsAre(HasSubstr("executor motion (line 7) requests CPU 5,")));
}

TEST(Placement, UsesAnIsolatedCpuOnlyForTheExecutorThatRequestsIt) {
  const model::Cpus cpus{.online = {0, 1, 2, 3}, .permitted = {0, 1, 2, 3}, .ordinary = {0, 1}};
  const Placement placement = place(with({executor("a"), executor("b", 3)}), cpus);
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{1}, Cpus{3}));
  EXPECT_THAT(placement.background, ElementsAre(0));
  EXPECT_THAT(placement.warnings, IsEmpty());
}

TEST(Placement, NamesTheCpusetLimitThatExcludesTheRequestedCpu) {
  const model::Cpus cpus{.online = {0, 2, 3}, .permitted = {0, 2}, .ordinary = {0}};
  EXPECT_THAT(
      missing_cpus(with({executor("a", 2), executor("b", 3), executor("c", 1)}), cpus),
      ElementsAre("executor b requests CPU 3, which a cpuset limit (of a cgroup, a service or a container) "
                  "excludes; Takt may use CPUs 0,2, and the node chooses one of them",
                  "executor c requests CPU 1, which this machine does not have or has switched off; Takt "
                  "may use CPUs 0,2, and the node chooses one of them"));
  EXPECT_THAT(place(with({executor("b", 3)}), cpus).executors, ElementsAre(Cpus{0}));
}

TEST(Placement, UsesOnlyAllowedCpus) {
  const Placement placement = place(with({executor("a"), executor("b", 2)}), model::Cpus::all({4, 7}));
  EXPECT_THAT(placement.executors, ElementsAre(Cpus{7}, Cpus{7}));
  EXPECT_THAT(placement.background, ElementsAre(4));
  EXPECT_EQ(placement.warnings.size(), 1U);
}

TEST(Placement, LetsOtherThreadsUseAllCpusIfExecutorsRequestAll) {
  const Placement placement = place(with({executor("a", 0), executor("b", 1)}), model::Cpus::all({0, 1}));
  EXPECT_THAT(placement.background, ElementsAre(0, 1));
  EXPECT_EQ(placement.warnings.size(), 1U);
}

TEST(Placement, LeavesAllCpusToOtherThreadsWithoutExecutors) {
  const Placement placement = place(with({}), model::Cpus::all({0, 1}));
  EXPECT_THAT(placement.executors, IsEmpty());
  EXPECT_THAT(placement.background, ElementsAre(0, 1));
}

model::Device programs(int count) {
  model::Device device;
  for (int i = 0; i < count; ++i) device.modules.emplace_back().type = model::ModuleType::process;
  device.modules.emplace_back();  // a thread module, which does not count as a program
  model::Module& background = device.modules.emplace_back();
  background.type = model::ModuleType::process;
  background.operation = model::Operation::non_real;
  return device;
}

TEST(ProgramsPerCpu, AreAveragedAndRoundedUp) {
  const Placement two{.executors = {}, .background = {0, 1}, .warnings = {}};
  EXPECT_EQ(programs_on_one(programs(0), two), 1);
  EXPECT_EQ(programs_on_one(programs(2), two), 1);
  EXPECT_EQ(programs_on_one(programs(3), two), 2);
}

}  // namespace
}  // namespace takt::schedule::placement_test
