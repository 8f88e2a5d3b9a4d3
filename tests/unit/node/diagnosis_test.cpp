#include <takt/node/diagnosis.hpp>

#include <gmock/gmock.h>

#include <algorithm>
#include <set>

namespace takt::node::diagnosis_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::Not;

// Returns a machine that is fully set up for real time.
os::Machine good_machine() {
  os::Machine machine;
  machine.kernel = "6.1.0-31-rt-amd64";
  machine.preemption = os::Preemption::real_time;
  machine.throttling = os::Throttling{};
  machine.priority = os::Limit{98, 98};
  machine.locked = os::Limit{};
  machine.files = os::Limit{1024, 524288};
  machine.online = {0, 1, 2, 3};
  machine.isolated = {3};
  machine.tickless = {3};
  for (int cpu = 0; cpu < 4; ++cpu) {
    machine.processors.push_back({.number = cpu,
                                  .governor = "performance",
                                  .idle_states = {{"POLL", microseconds{0}}, {"C1", microseconds{2}}},
                                  .siblings = {cpu}});
  }
  machine.clock = "tsc";
  machine.clocks = {"tsc", "hpet"};
  machine.interrupts = {{.number = 16, .name = "eth0", .cpus = {0, 1}}};
  machine.timer_slack = microseconds{50};
  machine.swap_bytes = 0;
  machine.shared_memory_bytes = 1ULL << 30;
  machine.receive_buffer_bytes = 4U << 20;
  machine.send_buffer_bytes = 4U << 20;
  machine.huge_pages = "madvise";
  machine.numa_balancing = false;
  machine.time = os::ProcessorTime{1000000, 0};
  return machine;
}

os::Trial good_trial() {
  os::Trial trial;
  trial.cpus = {.online = {0, 1, 2, 3}, .permitted = {0, 1, 2, 3}, .ordinary = {0, 1, 2}};
  trial.timer_resolution = Nanoseconds{1};
  trial.wall_clock_error = milliseconds{2};
  trial.wake_ups = {500, microseconds{3}, microseconds{8}, microseconds{21}};
  trial.stolen_share = 0.0;
  return trial;
}

Finding finding(const std::string& name, const os::Machine& machine, const os::Trial& trial = good_trial()) {
  for (const Finding& each : diagnose(machine, trial)) {
    if (each.name == name) return each;
  }
  ADD_FAILURE() << "there is no check " << name;
  return {};
}

TEST(Diagnosis, FindsNoProblemOnAWellConfiguredMachine) {
  for (const Finding& each : diagnose(good_machine(), good_trial())) {
    EXPECT_EQ(each.severity, Severity::good) << each.name << ": " << each.found;
    EXPECT_EQ(each.cure, "") << each.name;
  }
}

TEST(Diagnosis, ExplainsEveryCheckEvenIfNothingIsKnownAboutTheMachine) {
  std::set<std::string> names;
  for (const Finding& each : diagnose({}, {})) {
    EXPECT_NE(each.found, "") << each.name;
    EXPECT_NE(each.why, "") << each.name;
    EXPECT_TRUE(names.insert(each.name).second) << each.name;
  }
  EXPECT_EQ(names.size(), 22U);
}

TEST(Diagnosis, SuggestsAFixForEveryProblem) {
  os::Machine machine = good_machine();
  machine.preemption = os::Preemption::none;
  machine.throttling = os::Throttling{.kept = milliseconds{50}};
  machine.isolated.clear();
  machine.irqbalance = true;
  machine.processors[1] = {1, "powersave", {{"C6", microseconds{133}}}, {0, 1}};
  machine.clock = "hpet";
  machine.swap_bytes = 1 << 30;
  machine.shared_memory_bytes = 1 << 20;
  machine.receive_buffer_bytes = 212992;
  machine.huge_pages = "always";
  machine.hypervisor = "KVM";
  machine.memfd_noexec = 2;
  machine.files = os::Limit{256, 256};
  machine.time = os::ProcessorTime{100, 5};
  os::Trial trial;
  trial.cpus = {.online = {0, 1, 2, 3}, .permitted = {0, 1}, .ordinary = {0, 1}};
  trial.priority = fail("SCHED_FIFO 1 is denied", "be root");
  trial.locking = fail("mlockall is denied beyond 8192 KiB");
  trial.idle_held = fail("/dev/cpu_dma_latency cannot be opened");
  trial.timer_resolution = milliseconds{4};
  trial.wake_ups = {500, microseconds{60}, milliseconds{2}, milliseconds{9}};
  for (const Finding& each : diagnose(machine, trial)) {
    EXPECT_NE(each.severity, Severity::good) << each.name << ": " << each.found;
    EXPECT_NE(each.cure, "") << each.name;
  }
}

TEST(Diagnosis, RatesTheKernelByItsPreemptionMode) {
  os::Machine machine = good_machine();
  const auto severity = [&](os::Preemption preemption) {
    machine.preemption = preemption;
    return finding("preemption", machine).severity;
  };
  EXPECT_EQ(severity(os::Preemption::none), Severity::spoils);
  EXPECT_EQ(severity(os::Preemption::voluntary), Severity::spoils);
  EXPECT_EQ(severity(os::Preemption::lazy), Severity::note);
  EXPECT_EQ(severity(os::Preemption::full), Severity::note);
  EXPECT_EQ(severity(os::Preemption::real_time), Severity::good);
  machine.preemption.reset();
  EXPECT_EQ(finding("preemption", machine).severity, Severity::note)
      << "an unknown mode does not count as a problem";
}

TEST(Diagnosis, SaysThatDeniedPriorityOrMemoryLockingSpoilsRealTime) {
  os::Trial trial = good_trial();
  trial.priority = fail("SCHED_FIFO 1 is denied: Operation not permitted");
  trial.locking = fail("mlockall is denied beyond 64 KiB");
  os::Machine machine = good_machine();
  machine.priority = os::Limit{0, 0};
  EXPECT_EQ(finding("priority", machine, trial).severity, Severity::spoils);
  EXPECT_THAT(finding("priority", machine, trial).found, HasSubstr("rtprio limit 0"));
  EXPECT_EQ(finding("memory", machine, trial).severity, Severity::spoils);
  EXPECT_THAT(finding("memory", machine, trial).cure, HasSubstr("memlock"));
}

TEST(Diagnosis, AcceptsRightsThatOnlyTaktNodeHas) {
  os::Trial trial = good_trial();
  trial.priority = fail("SCHED_FIFO 1 is denied", "be root");
  trial.locking = fail("mlockall is denied", "be root");
  trial.node_is_real_time = true;
  EXPECT_EQ(finding("priority", good_machine(), trial).found,
            "SCHED_FIFO is granted to takt-node, whose file has capabilities");
  EXPECT_EQ(finding("memory", good_machine(), trial).severity, Severity::good);
}

TEST(Diagnosis, DoesNotBlameTaktNodeForLateWakeUpsOfAnotherProgramWithoutItsRights) {
  os::Trial trial = good_trial();
  trial.priority = fail("SCHED_FIFO 1 is denied", "be root");
  trial.wake_ups.p99 = milliseconds{2};
  EXPECT_EQ(finding("wake-up", good_machine(), trial).severity, Severity::spoils);
  trial.node_is_real_time = true;
  const Finding found = finding("wake-up", good_machine(), trial);
  EXPECT_EQ(found.severity, Severity::note);
  EXPECT_THAT(found.found, HasSubstr("does not hold for takt-node"));
  EXPECT_EQ(found.cure, "run takt doctor as root to measure wake-ups under SCHED_FIFO");
}

TEST(Diagnosis, SaysThatAComponentCannotBeLoadedIfMemoryIsNotExecutable) {
  os::Machine machine = good_machine();
  machine.memfd_noexec = 1;  // copies that ask to be executable still are
  EXPECT_EQ(finding("components", machine).severity, Severity::good);
  machine.memfd_noexec = 2;
  const Finding found = finding("components", machine);
  EXPECT_EQ(found.severity, Severity::spoils);
  EXPECT_THAT(found.found, HasSubstr("vm.memfd_noexec is 2"));
  EXPECT_EQ(found.cure, "run sysctl -w vm.memfd_noexec=1");
}

TEST(Diagnosis, SaysWhyTaktNodeDoesNotStart) {
  os::Trial trial = good_trial();
  trial.node_error = "libtakt_component.so.0.2: cannot open shared object file";
  EXPECT_THAT(finding("priority", good_machine(), trial).found, HasSubstr("cannot open shared object file"));
  EXPECT_THAT(finding("priority", good_machine(), trial).cure, HasSubstr("capabilities"));
}

TEST(Diagnosis, NamesTheCapabilityThatRootLacks) {
  os::Trial trial = good_trial();
  trial.root = true;
  trial.priority = fail("SCHED_FIFO 1 is denied", "root lacks CAP_SYS_NICE here");
  EXPECT_EQ(finding("priority", good_machine(), trial).cure, "root lacks CAP_SYS_NICE here");
  trial.root = false;
  EXPECT_THAT(finding("priority", good_machine(), trial).cure,
              HasSubstr("setcap cap_sys_nice,cap_ipc_lock+ep"));
}

TEST(Diagnosis, SaysThatSwapSpoilsRealTimeOnlyIfMemoryCannotBeLocked) {
  os::Machine machine = good_machine();
  machine.swap_bytes = 1 << 30;
  EXPECT_EQ(finding("swap", machine).severity, Severity::note);
  os::Trial trial = good_trial();
  trial.locking = fail("refused");
  EXPECT_EQ(finding("swap", machine, trial).severity, Severity::spoils);
}

TEST(Diagnosis, SuggestsTheThrottlingFixThatTheKernelSupports) {
  os::Machine machine = good_machine();
  machine.throttling = os::Throttling{.kept = milliseconds{50}};
  EXPECT_THAT(finding("throttling", machine).cure, HasSubstr("kernel.sched_rt_runtime_us=-1"));
  machine.throttling->fair_server = true;
  EXPECT_THAT(finding("throttling", machine).cure, HasSubstr("fair_server"));
  EXPECT_THAT(finding("throttling", machine).cure, Not(HasSubstr("sched_rt_runtime_us")));
}

TEST(Diagnosis, ReportsInterruptsOnTheCpusOfExecutors) {
  os::Machine machine = good_machine();
  machine.interrupts[0].cpus = {3};
  EXPECT_THAT(finding("interrupts", machine).found, HasSubstr("16 (eth0)"));
  EXPECT_THAT(finding("interrupts", machine).cure, HasSubstr("echo 0-2 >"));
  machine.isolated.clear();  // without isolated CPUs, executors get the highest CPU
  os::Trial trial = good_trial();
  trial.cpus = model::Cpus::all({0, 1, 2, 3});
  EXPECT_EQ(finding("interrupts", machine, trial).severity, Severity::note);
  machine.interrupts[0].cpus = {2};
  EXPECT_EQ(finding("interrupts", machine, trial).severity, Severity::good);
  machine.irqbalance = true;
  EXPECT_THAT(finding("interrupts", machine).cure, HasSubstr("irqbalance"));
}

TEST(Diagnosis, SaysHowAnExecutorGetsAnIsolatedCpu) {
  os::Machine machine = good_machine();
  EXPECT_EQ(finding("isolation", machine).found,
            "CPU 3 is isolated, for executors that request it (cpu=\"3\")");
  machine.isolated.clear();
  os::Trial trial = good_trial();
  trial.cpus.permitted = {0, 1};
  EXPECT_THAT(finding("isolation", machine, trial).cure, HasSubstr("isolcpus=1 "));
}

TEST(Diagnosis, NamesTheCpusetLimitThatExcludesCpus) {
  os::Trial trial = good_trial();
  trial.cpus.permitted = {0, 1};
  EXPECT_EQ(finding("CPU limit", good_machine(), trial).severity, Severity::note);
  EXPECT_THAT(finding("CPU limit", good_machine(), trial).found, HasSubstr("excludes CPUs 2-3"));
  EXPECT_EQ(finding("isolation", good_machine(), trial).severity, Severity::note);
  EXPECT_THAT(finding("isolation", good_machine(), trial).found, HasSubstr("limit excludes CPU 3"));
}

TEST(Diagnosis, AcceptsDeepIdleStatesThatTaktCanPrevent) {
  os::Machine machine = good_machine();
  machine.processors[0].idle_states.push_back({"C6", microseconds{133}});
  EXPECT_EQ(finding("idle states", machine).severity, Severity::good);
  os::Trial trial = good_trial();
  trial.idle_held = fail("/dev/cpu_dma_latency cannot be opened");
  EXPECT_EQ(finding("idle states", machine, trial).severity, Severity::note);
  machine.processors[0].idle_states.back().disabled = true;
  EXPECT_EQ(finding("idle states", machine, trial).severity, Severity::good);
}

TEST(Diagnosis, NotesThatNothingSynchronisesTheWallClock) {
  os::Trial trial = good_trial();
  EXPECT_EQ(finding("wall clock", good_machine(), trial).found,
            "the wall clock is synchronised, with an error of at most 2 ms");
  trial.wall_clock_error.reset();
  const Finding found = finding("wall clock", good_machine(), trial);
  EXPECT_EQ(found.severity, Severity::note);
  EXPECT_THAT(found.cure, HasSubstr("install chrony"));
}

TEST(Diagnosis, RatesStolenTimeByItsShareSinceBoot) {
  os::Machine machine = good_machine();
  os::Trial trial = good_trial();
  trial.stolen_share = 0.02;
  EXPECT_EQ(finding("stolen time", machine, trial).severity, Severity::note) << "the next second may differ";
  EXPECT_THAT(finding("stolen time", machine, trial).mend_on, HasSubstr("host"));
  machine.time = os::ProcessorTime{100000, 200};
  EXPECT_EQ(finding("stolen time", machine).severity, Severity::note);
  machine.time = os::ProcessorTime{100000, 2000};
  EXPECT_EQ(finding("stolen time", machine).severity, Severity::spoils);
}

TEST(Diagnosis, RatesWakeUpsByTheirDelay) {
  os::Trial trial = good_trial();
  trial.wake_ups = {500, microseconds{30}, microseconds{101}, microseconds{300}};
  EXPECT_EQ(finding("wake-up", good_machine(), trial).severity, Severity::note);
  trial.wake_ups = {500, microseconds{30}, microseconds{250}, milliseconds{3}};
  EXPECT_EQ(finding("wake-up", good_machine(), trial).severity, Severity::note);
  trial.wake_ups = {500, microseconds{30}, microseconds{251}, microseconds{300}};
  EXPECT_EQ(finding("wake-up", good_machine(), trial).severity, Severity::spoils);
  trial.wake_ups = {};
  EXPECT_EQ(finding("wake-up", good_machine(), trial).severity, Severity::spoils);
}

TEST(Diagnosis, SaysWhichFixesMustBeMadeOutsideASealedContainer) {
  os::Machine machine = good_machine();
  machine.huge_pages = "always";
  machine.container = "/.dockerenv";
  EXPECT_EQ(finding("huge pages", machine).mend_on, "");
  machine.sealed = true;
  EXPECT_THAT(finding("huge pages", machine).mend_on, HasSubstr("container"));
  os::Trial trial = good_trial();
  trial.priority = fail("refused");
  EXPECT_EQ(finding("priority", machine, trial).mend_on, "") << "a container can be granted priority";
}

}  // namespace
}  // namespace takt::node::diagnosis_test
