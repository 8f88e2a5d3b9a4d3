// Tests with artificial /proc and /sys folders, which can describe any machine.
#include <takt/os/machine.hpp>

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include <takt/os/kernel_news.hpp>
#include <takt/os/real_time.hpp>

namespace takt::os::machine_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::IsEmpty;

class MachineInspection : public testing::Test {
 protected:
  void SetUp() override {
    root_ = testing::TempDir() + "takt-machine-" + std::to_string(::getpid());
    std::filesystem::remove_all(root_);
    std::filesystem::create_directories(root_);
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  void put(const std::string& file, const std::string& text) {
    const std::filesystem::path path = std::filesystem::path{root_} / file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream{path} << text << "\n";
  }
  void kernel(const std::string& release, const std::string& version) {
    put("proc/sys/kernel/osrelease", release);
    put("proc/sys/kernel/version", version);
  }
  [[nodiscard]] Machine read() const { return read_machine(root_); }

  std::string root_;
};

TEST_F(MachineInspection, GivesNoValuesIfProcAndSysAreEmpty) {
  const Machine machine = read();
  EXPECT_FALSE(machine.preemption.has_value());
  EXPECT_FALSE(machine.throttling.has_value());
  EXPECT_FALSE(machine.priority.has_value());
  EXPECT_FALSE(machine.swap_bytes.has_value());
  EXPECT_FALSE(machine.time.has_value());
  EXPECT_FALSE(machine.timer_slack.has_value());
  EXPECT_THAT(machine.online, IsEmpty());
  EXPECT_THAT(machine.interrupts, IsEmpty());
  EXPECT_EQ(machine.hypervisor, "");
  EXPECT_EQ(machine.container, "");
}

TEST_F(MachineInspection, ReadsThePreemptionOfEachKindOfKernel) {
  kernel("6.1.0-31-rt-amd64", "#1 SMP PREEMPT_RT Debian 6.1.128-1");
  EXPECT_EQ(read().preemption, Preemption::real_time);
  kernel("6.1.0", "#1 SMP PREEMPT Wed");
  EXPECT_EQ(read().preemption, Preemption::full);
  kernel("6.13.0", "#1 SMP PREEMPT_LAZY Wed");
  EXPECT_EQ(read().preemption, Preemption::lazy);
  kernel("4.19.0", "#1 SMP Debian");
  EXPECT_EQ(read().preemption, Preemption::voluntary);
}

TEST_F(MachineInspection, RecognizesAPatchedRealTimeKernel) {
  kernel("5.4.0", "#1 SMP PREEMPT");
  put("sys/kernel/realtime", "1");
  EXPECT_EQ(read().preemption, Preemption::real_time);
}

TEST_F(MachineInspection, ReadsTheDynamicPreemptionModeChosenLast) {
  kernel("6.1.0-31-amd64", "#1 SMP PREEMPT_DYNAMIC Debian 6.1.128-1");
  EXPECT_FALSE(read().preemption.has_value());
  put("boot/config-6.1.0-31-amd64",
      "# CONFIG_PREEMPT is not set\nCONFIG_PREEMPT_VOLUNTARY=y\nCONFIG_PREEMPT_DYNAMIC=y");
  EXPECT_EQ(read().preemption, Preemption::voluntary);
  put("proc/cmdline", "quiet preempt=none root=/dev/sda1 preempt=full");
  EXPECT_EQ(read().preemption, Preemption::full);
  put("sys/kernel/debug/sched/preempt", "(none) voluntary full");
  EXPECT_EQ(read().preemption, Preemption::none);
}

TEST_F(MachineInspection, ComputesTheThrottledTimeAsPeriodMinusRuntime) {
  kernel("6.1.0", "");
  put("proc/sys/kernel/sched_rt_period_us", "1000000");
  put("proc/sys/kernel/sched_rt_runtime_us", "950000");
  const auto throttling = read_throttling(root_);
  ASSERT_TRUE(throttling.has_value());
  EXPECT_EQ(throttling->kept, milliseconds{50});
  EXPECT_EQ(throttling->period, milliseconds{1000});
  EXPECT_FALSE(throttling->fair_server);
  EXPECT_TRUE(throttling->on());
  put("proc/sys/kernel/sched_rt_runtime_us", "-1");
  EXPECT_FALSE(read_throttling(root_)->on());
}

TEST_F(MachineInspection, ReadsTheFairServerSinceLinux612) {
  kernel("6.11.9", "");
  put("proc/sys/kernel/sched_rt_period_us", "1000000");
  put("proc/sys/kernel/sched_rt_runtime_us", "-1");
  EXPECT_FALSE(read_throttling(root_)->on());
  kernel("6.12.0-1-amd64", "");
  auto throttling = read_throttling(root_);
  EXPECT_TRUE(throttling->fair_server);
  EXPECT_TRUE(throttling->on()) << "the fair server ignores the file with -1";
  EXPECT_FALSE(throttling->seen);
  put("sys/kernel/debug/sched/fair_server/cpu0/runtime", "0");
  put("sys/kernel/debug/sched/fair_server/cpu0/period", "1000000000");
  throttling = read_throttling(root_);
  EXPECT_TRUE(throttling->seen);
  EXPECT_FALSE(throttling->on());
  put("sys/kernel/debug/sched/fair_server/cpu1/runtime", "20000000");
  put("sys/kernel/debug/sched/fair_server/cpu1/period", "500000000");
  throttling = read_throttling(root_);
  EXPECT_EQ(throttling->kept, milliseconds{20});
  EXPECT_EQ(throttling->period, milliseconds{500});
  kernel("7.0.0", "");
  EXPECT_TRUE(read_throttling(root_)->fair_server);
}

TEST_F(MachineInspection, ReadsNumericAndUnlimitedLimits) {
  put("proc/self/limits",
      "Limit                     Soft Limit           Hard Limit           Units     \n"
      "Max open files            1024                 524288               files     \n"
      "Max locked memory         8388608              unlimited            bytes     \n"
      "Max realtime priority     0                    98                             ");
  const Machine machine = read();
  EXPECT_EQ(machine.files->soft, 1024U);
  EXPECT_EQ(machine.files->hard, 524288U);
  EXPECT_EQ(machine.locked->soft, 8388608U);
  EXPECT_FALSE(machine.locked->hard.has_value());
  EXPECT_EQ(machine.priority->soft, 0U);
  EXPECT_EQ(machine.priority->hard, 98U);
}

TEST_F(MachineInspection, ReadsGovernorsIdleStatesAndSiblingsOfCpus) {
  const std::string cpus = "sys/devices/system/cpu/";
  put(cpus + "online", "0-1");
  put(cpus + "isolated", "1");
  put(cpus + "nohz_full", "(null)");
  put(cpus + "cpu1/cpufreq/scaling_governor", "powersave");
  put(cpus + "cpu1/cpuidle/state0/name", "POLL");
  put(cpus + "cpu1/cpuidle/state0/latency", "0");
  put(cpus + "cpu1/cpuidle/state1/name", "C6");
  put(cpus + "cpu1/cpuidle/state1/latency", "133");
  put(cpus + "cpu1/cpuidle/state1/disable", "1");
  put(cpus + "cpu1/topology/thread_siblings_list", "0-1");
  const Machine machine = read();
  EXPECT_THAT(machine.isolated, ElementsAre(1));
  EXPECT_THAT(machine.tickless, IsEmpty());
  ASSERT_EQ(machine.processors.size(), 2U);
  EXPECT_EQ(machine.processors[0].governor, "");
  const Processor& second = machine.processors[1];
  EXPECT_EQ(second.governor, "powersave");
  ASSERT_EQ(second.idle_states.size(), 2U);
  EXPECT_EQ(second.idle_states[1].name, "C6");
  EXPECT_EQ(second.idle_states[1].exit_latency, microseconds{133});
  EXPECT_TRUE(second.idle_states[1].disabled);
  EXPECT_THAT(second.siblings, ElementsAre(0, 1));
}

TEST_F(MachineInspection, ListsOnlyInterruptsWithAHandler) {
  put("proc/irq/7/smp_affinity_list", "0-3");
  put("proc/irq/16/eth0/spurious", "");
  put("proc/irq/16/smp_affinity_list", "0-3");
  put("proc/irq/16/effective_affinity_list", "2");
  put("proc/irq/17/sda/spurious", "");
  put("proc/irq/17/smp_affinity_list", "0,2");
  const Machine machine = read();
  ASSERT_EQ(machine.interrupts.size(), 2U);
  EXPECT_EQ(machine.interrupts[0].name, "eth0");
  EXPECT_THAT(machine.interrupts[0].cpus, ElementsAre(2));
  EXPECT_THAT(machine.interrupts[1].cpus, ElementsAre(0, 2));
}

TEST_F(MachineInspection, ReadsTheOtherSettingsOfTheKernel) {
  put("proc/812/comm", "irqbalance");
  put("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet");
  put("sys/devices/system/clocksource/clocksource0/available_clocksource", "tsc hpet acpi_pm ");
  put("sys/kernel/mm/transparent_hugepage/enabled", "always [madvise] never");
  put("proc/sys/kernel/numa_balancing", "1");
  put("proc/sys/vm/memfd_noexec", "2");
  put("proc/self/timerslack_ns", "50000");
  put("proc/sys/net/core/rmem_max", "212992");
  put("proc/swaps",
      "Filename\t\t\t\tType\t\tSize\t\tUsed\t\tPriority\n/dev/sda2 partition\t1024\t0\t-2\n/swap file 2048 1 "
      "-3");
  const Machine machine = read();
  EXPECT_TRUE(machine.irqbalance);
  EXPECT_EQ(machine.clock, "hpet");
  EXPECT_THAT(machine.clocks, ElementsAre("tsc", "hpet", "acpi_pm"));
  EXPECT_EQ(machine.huge_pages, "madvise");
  EXPECT_EQ(machine.numa_balancing, true);
  EXPECT_EQ(machine.memfd_noexec, 2);
  EXPECT_EQ(machine.timer_slack, microseconds{50});
  EXPECT_EQ(machine.receive_buffer_bytes, 212992U);
  EXPECT_FALSE(machine.send_buffer_bytes.has_value());
  EXPECT_EQ(machine.swap_bytes, 3072U * 1024);
}

TEST_F(MachineInspection, ReadsZeroBytesOfSwapIfThereIsNone) {
  put("proc/swaps", "Filename Type Size Used Priority");
  EXPECT_EQ(read().swap_bytes, 0U);
}

TEST_F(MachineInspection, DetectsVirtualMachinesAndContainers) {
  put("proc/cpuinfo", "processor : 0\nflags\t\t: fpu vme hypervisor lm\n");
  EXPECT_EQ(read().hypervisor, "a hypervisor");
  put("sys/class/dmi/id/sys_vendor", "QEMU");
  put("sys/class/dmi/id/product_name", "Standard PC");
  EXPECT_EQ(read().hypervisor, "QEMU Standard PC");
  put("proc/cpuinfo", "processor : 0\nflags\t\t: fpu vme lm\n");
  EXPECT_EQ(read().hypervisor, "");
  put(".dockerenv", "");
  EXPECT_EQ(read().container, "/.dockerenv");
}

TEST_F(MachineInspection, GivesStolenTimeAsAShareOfTheTimeOfAllCpus) {
  put("proc/stat", "cpu  100 0 100 700 50 10 10 30 40 0\ncpu0 1 2 3 4 5 6 7 8 9 0");
  const auto before = read_processor_time(root_);
  ASSERT_TRUE(before.has_value());
  EXPECT_EQ(before->all, 1000U) << "the time of guests is already part of the user time";
  EXPECT_DOUBLE_EQ(before->stolen_share(), 0.03);
  put("proc/stat", "cpu  150 0 100 700 50 10 10 80 40 0");
  EXPECT_DOUBLE_EQ(read_processor_time(root_)->stolen_share(*before), 0.5);
  EXPECT_DOUBLE_EQ(before->stolen_share(*before), 0.0);
  put("proc/stat", "cpu 1 2 3 4");
  EXPECT_FALSE(read_processor_time(root_).has_value());
}

TEST_F(MachineInspection, GivesNoValueForInvalidText) {
  kernel("nonsense", "");
  put("proc/sys/kernel/sched_rt_period_us", "0");
  put("proc/sys/kernel/sched_rt_runtime_us", "x");
  put("sys/devices/system/cpu/online", "0-99999999999");
  put("proc/self/limits", "Max open files");
  const Machine machine = read();
  EXPECT_FALSE(machine.throttling.has_value());
  EXPECT_THAT(machine.online, IsEmpty());
  EXPECT_FALSE(machine.files.has_value());
}

TEST(CpuList, CanBeParsedAndFormatted) {
  EXPECT_THAT(parse_cpus(""), IsEmpty());
  EXPECT_THAT(parse_cpus("3"), ElementsAre(3));
  EXPECT_THAT(parse_cpus("0-2,5"), ElementsAre(0, 1, 2, 5));
  EXPECT_THAT(parse_cpus("2-x"), IsEmpty());
  EXPECT_EQ(model::cpus_text({}), "");
  EXPECT_EQ(model::cpus_text({0, 1, 2, 5}), "0-2,5");
}

// The kernel's option isolcpus= has the same effect: threads get the isolated CPUs only on request.
TEST(Cpus, PermitsACpuThatTheAffinityOfTheProcessLeavesOut) {
  const model::Cpus before = read_cpus();
  ASSERT_FALSE(before.ordinary.empty());
  model::Cpus inside;
  auto thread = Thread::start(
      {.name = "t", .cpus = {before.ordinary.front()}}, [&inside] { inside = read_cpus(); }, nullptr);
  thread->join();
  EXPECT_THAT(inside.ordinary, ElementsAre(before.ordinary.front()));
  EXPECT_EQ(inside.permitted, before.permitted);
  EXPECT_EQ(inside.online, before.online);
  EXPECT_EQ(read_cpus(), before) << "the trial changes no CPU of the calling thread";
}

TEST(Machine, ReadsTheKernelAndCpusOfThisMachine) {
  const Machine machine = read_machine();
  EXPECT_NE(machine.kernel, "");
  EXPECT_FALSE(machine.online.empty());
  EXPECT_TRUE(machine.time.has_value());
}

TEST(KernelNews, ContainsOnlyTheTextOfEachMessage) {
  EXPECT_EQ(kernel_text("4,812,5123456,-;sched: RT throttling activated\n SUBSYSTEM=cpu\n"),
            "sched: RT throttling activated");
  EXPECT_EQ(kernel_text("no record"), "");
}

TEST(KernelNews, OmitsMessagesFromBeforeItsCreation) {
  KernelNews news;
  // The kernel logs its version when it boots, so this message is always older than `news`.
  while (const auto text = news.next()) EXPECT_THAT(*text, testing::Not(testing::HasSubstr("Linux version")));
}

}  // namespace
}  // namespace takt::os::machine_test
