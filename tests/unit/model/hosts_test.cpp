#include <takt/model/hosts.hpp>

#include <gmock/gmock.h>

#include <string>
#include <utility>
#include <vector>

namespace takt::model::hosts_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Module thread(const std::string& name, const std::string& executor) {
  Module module;
  module.name = name;
  module.executor = executor;
  if (executor.empty()) module.operation = Operation::non_real;
  return module;
}
Module program(const std::string& name, const std::string& executor) {
  Module module = thread(name, executor);
  module.type = ModuleType::process;
  return module;
}

Executor executor(const std::string& name, bool own_host = false) {
  Executor executor;
  executor.name = name;
  executor.own_host = own_host;
  return executor;
}
Device device_of(std::vector<Executor> executors, std::vector<Module> modules) {
  Device device;
  device.name = "d";
  device.executors = std::move(executors);
  device.modules = std::move(modules);
  return device;
}

TEST(Hosts, ExecutorsWithoutTheirOwnHostShareOneHost) {
  const auto hosts =
      hosts_of(device_of({executor("fast"), executor("slow")},
                         {thread("a", "fast"), program("b", "slow"), thread("c", ""), program("d", "")}));
  ASSERT_EQ(hosts.size(), 1U);
  EXPECT_FALSE(hosts[0].is_own());
  EXPECT_THAT(hosts[0].executors, ElementsAre(0, 1));
  EXPECT_THAT(hosts[0].modules, ElementsAre(0, 2));
  EXPECT_THAT(hosts[0].programs, ElementsAre(1));
}

TEST(Hosts, AnExecutorCanHaveItsOwnHost) {
  const auto hosts =
      hosts_of(device_of({executor("fast", true), executor("slow")},
                         {thread("a", "fast"), program("b", "fast"), thread("c", "slow"), thread("d", "")}));
  ASSERT_EQ(hosts.size(), 2U);
  EXPECT_FALSE(hosts[0].is_own());
  EXPECT_THAT(hosts[0].executors, ElementsAre(1));
  EXPECT_THAT(hosts[0].modules, ElementsAre(2, 3));
  EXPECT_EQ(hosts[1].name, "fast");
  EXPECT_THAT(hosts[1].executors, ElementsAre(0));
  EXPECT_THAT(hosts[1].modules, ElementsAre(0));
  EXPECT_THAT(hosts[1].programs, ElementsAre(1));
}

TEST(Hosts, ThereIsNoSharedHostIfItWouldBeEmpty) {
  const auto hosts = hosts_of(device_of({executor("fast", true), executor("slow", true)},
                                        {thread("a", "fast"), thread("b", "slow")}));
  ASSERT_EQ(hosts.size(), 2U);
  EXPECT_EQ(hosts[0].name, "fast");
  EXPECT_EQ(hosts[1].name, "slow");
  EXPECT_THAT(hosts[1].modules, ElementsAre(1));
}

TEST(Hosts, AnEmptyDeviceHasASharedHost) {
  const auto hosts = hosts_of(device_of({executor("main")}, {}));
  ASSERT_EQ(hosts.size(), 1U);
  EXPECT_THAT(hosts[0].modules, IsEmpty());
}

}  // namespace
}  // namespace takt::model::hosts_test
