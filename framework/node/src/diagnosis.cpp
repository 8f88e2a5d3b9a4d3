#include <takt/node/diagnosis.hpp>

#include <algorithm>
#include <cstdio>
#include <iterator>

#include <takt/core/words.hpp>
#include <takt/os/process.hpp>
#include "conditions.hpp"

namespace takt::node {

namespace {

using os::Machine;
using os::Trial;
using takt::to_text;  // the overload for Severity would hide these functions

constexpr Nanoseconds kDeepIdle = std::chrono::microseconds{10};
constexpr double kStolenSpoils = 0.005;
constexpr double kStolenNote = 0.001;
// The limits of the delay of wake-ups: for their p99 and, if it is rare, for their maximum.
constexpr Nanoseconds kLateNote = std::chrono::microseconds{100};
constexpr Nanoseconds kLateSpoils = std::chrono::microseconds{250};  // a quarter of a common period, 1 ms
constexpr Nanoseconds kRarelyLateNote = std::chrono::milliseconds{1};
constexpr std::uint64_t kMiB = 1024 * 1024;
// The size of the buffer that a DDS reader needs for a burst of large samples.
constexpr std::uint64_t kSocketBuffer = kMiB;
constexpr std::uint64_t kFiles = 1024;
constexpr const char* kToNode = " to takt-node, whose file has capabilities";
constexpr const char* kHost = "the host of this virtual machine";

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f %%", share * 100);
  return text;
}

std::string amount(std::uint64_t bytes) {
  return bytes >= kMiB ? std::to_string(bytes / kMiB) + " MiB" : std::to_string(bytes / 1024) + " KiB";
}

std::string microseconds(Nanoseconds time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f us", static_cast<double>(time.count()) / 1e3);
  return text;
}

std::string limit_text(const std::optional<std::uint64_t>& limit) {
  return limit ? std::to_string(*limit) : "unlimited";
}

bool has(const std::vector<int>& cpus, int cpu) {
  return std::find(cpus.begin(), cpus.end(), cpu) != cpus.end();
}

std::string are(const std::vector<int>& cpus) {
  return model::cpus_in_words(cpus) + (cpus.size() == 1 ? " is" : " are");
}

std::vector<int> without(const std::vector<int>& all, const std::vector<int>& some) {
  std::vector<int> left;
  std::copy_if(all.begin(), all.end(), std::back_inserter(left), [&](int cpu) { return !has(some, cpu); });
  return left;
}

Finding preemption(const Machine& machine, const Trial&) {
  using os::Preemption;
  Finding finding{.name = "preemption",
                  .found = "the kernel " + machine.kernel,
                  .why =
                      "while the kernel works for another thread, a real-time thread waits until the kernel "
                      "can be preempted, which may take milliseconds"};
#ifdef __aarch64__
  const std::string kernel = "linux-image-rt-arm64";
#else
  const std::string kernel = "linux-image-rt-amd64";
#endif
  const std::string install = "run apt-get install " + kernel + ", and reboot";
  const std::string boot = "boot with preempt=full, or better, run apt-get install " + kernel + " and reboot";
  if (!machine.preemption) {
    finding.severity = Severity::note;
    finding.found += " selects its preemption mode at boot, and the mode cannot be read here";
    finding.cure = "run mount -t debugfs none /sys/kernel/debug as root, and then takt doctor";
    return finding;
  }
  switch (*machine.preemption) {
    case Preemption::none:
      finding.severity = Severity::spoils;
      finding.found += " is not preemptible";
      finding.cure = boot;
      break;
    case Preemption::voluntary:
      finding.severity = Severity::spoils;
      finding.found += " is preemptible in few places, if at all (voluntary, or none)";
      finding.cure = boot;
      break;
    case Preemption::lazy:
    case Preemption::full:
      finding.severity = Severity::note;
      finding.found += " is preemptible (" + std::string{to_text(*machine.preemption)} +
                       "), but not in interrupts or while it holds a spin lock";
      finding.cure = install;
      break;
    case Preemption::real_time:
      finding.found += " is PREEMPT_RT";
      break;
  }
  return finding;
}

// Returns the commands that add the libraries of this installation to the loader's cache; empty if they are
// in a folder of the system. For a program with capabilities, the loader ignores $ORIGIN in its list of
// folders.
std::string cache_libraries() {
  const std::string ours = os::private_directory();
  const std::string libraries = ours.substr(0, ours.find_last_of('/'));
  if (ours == os::program_directory() || libraries.starts_with("/usr/lib")) return "";
  return "echo " + libraries + " > /etc/ld.so.conf.d/takt.conf; ldconfig; ";
}

// Returns the cure for a right that Takt lacks. `limit` is a line of limits.conf. takt-node passes its
// capabilities on to takt-host and to the programs of process modules.
std::string grant(const std::string& limit, const Problem& problem, const Trial& trial) {
  if (trial.root) return problem.fix;
  return "run Takt as root; or run echo '" + limit + "' >> /etc/security/limits.conf, and log in again; or run " +
         cache_libraries() + "setcap cap_sys_nice,cap_ipc_lock+ep " + os::program_directory() + "/takt-node";
}

Finding priority(const Machine& machine, const Trial& trial) {
  Finding finding{.name = "priority",
                  .found = "SCHED_FIFO is granted",
                  .why = "without SCHED_FIFO, any busy program delays control loops by milliseconds or more"};
  if (!trial.node_error.empty()) {
    finding.severity = Severity::spoils;
    finding.found = "takt-node does not start: " + trial.node_error;
    finding.cure = "if takt-node has file capabilities (getcap), run " + cache_libraries() + "takt doctor";
    return finding;
  }
  if (!trial.priority && trial.node_is_real_time) finding.found += kToNode;
  if (trial.priority || trial.node_is_real_time) return finding;
  finding.severity = Severity::spoils;
  const Problem& problem = trial.priority.problems().front();
  finding.found = problem.what;
  if (machine.priority) finding.found += " (rtprio limit " + limit_text(machine.priority->hard) + ")";
  finding.cure = grant("* - rtprio 98", problem, trial);
  return finding;
}

Finding memory(const Machine& machine, const Trial& trial) {
  Finding finding{.name = "memory",
                  .found = "mlockall is granted",
                  .why =
                      "an access to a page that is not in memory costs microseconds, or milliseconds if the "
                      "page comes from a disk"};
  if (!trial.locking && trial.node_is_real_time) finding.found += kToNode;
  if (trial.locking || trial.node_is_real_time) return finding;
  finding.severity = Severity::spoils;
  const Problem& problem = trial.locking.problems().front();
  finding.found = problem.what;
  if (machine.locked && machine.locked->hard)
    finding.found += " (hard limit " + amount(*machine.locked->hard) + ")";
  finding.cure = grant("* - memlock unlimited", problem, trial);
  return finding;
}

Finding swap(const Machine& machine, const Trial& trial) {
  Finding finding{.name = "swap",
                  .found = "no swap space is enabled",
                  .why =
                      "a program that was swapped out waits for the disk; locked memory is never swapped "
                      "out, but the programs that a cell communicates with may be"};
  if (!machine.swap_bytes || *machine.swap_bytes == 0) return finding;
  finding.severity = trial.locking || trial.node_is_real_time ? Severity::note : Severity::spoils;
  finding.found = amount(*machine.swap_bytes) + " of swap space is enabled";
  finding.cure = "run swapoff -a, and remove the swap space from /etc/fstab";
  return finding;
}

Finding throttling(const Machine& machine, const Trial&) {
  Finding finding{
      .name = "throttling",
      .found = "the kernel does not throttle real-time threads",
      .why =
          "throttling interrupts an executor that never sleeps (wakeup=\"spin\"), but not an executor that "
          "sleeps"};
  if (!machine.throttling) {
    finding.found = "the kernel's throttling settings cannot be read";
    return finding;
  }
  const os::Throttling& t = *machine.throttling;
  if (!t.on()) return finding;
  finding.severity = Severity::note;
  finding.found =
      "the kernel reserves " + to_text(t.kept) + " of each " + to_text(t.period) + " for ordinary threads" +
      (t.fair_server ? " that wait for a CPU (fair server)" : " (real-time throttling)") +
      (t.seen ? "" : "; these are the kernel's defaults, because the present values cannot be read");
  finding.cure = "run " + throttling_cure(t);
  return finding;
}

Finding cpu_limit(const Machine&, const Trial& trial) {
  Finding finding{.name = "CPU limit",
                  .found = "Takt may use all CPUs of this machine",
                  .why = "an executor cannot use a CPU that a cpuset limit excludes"};
  const std::vector<int> excluded = without(trial.cpus.online, trial.cpus.permitted);
  if (excluded.empty()) return finding;
  finding.severity = Severity::note;
  finding.found = "a cpuset limit (of a cgroup, a service or a container) excludes " +
                  model::cpus_in_words(excluded);
  finding.cure =
      "if an executor needs one of them, add it to AllowedCPUs= of the service, or to --cpuset-cpus of the "
      "container";
  return finding;
}

Finding isolation(const Machine& machine, const Trial& trial) {
  Finding finding{.name = "isolation",
                  .found = "",
                  .why =
                      "on a shared CPU, a control loop finds its caches cold and waits for the kernel's own "
                      "work"};
  if (!machine.isolated.empty()) {
    finding.found = are(machine.isolated) + " isolated";
    if (const std::vector<int> excluded = without(machine.isolated, trial.cpus.permitted);
        !excluded.empty()) {
      finding.severity = Severity::note;
      finding.found += ", but a cpuset limit excludes " + model::cpus_in_words(excluded);
      finding.cure = "extend the limit (see CPU limit)";
      return finding;
    }
    finding.found += ", for executors that request ";
    finding.found += machine.isolated.size() == 1
                         ? "it (cpu=\"" + std::to_string(machine.isolated.back()) + "\")"
                         : "one of them, as in cpu=\"" + std::to_string(machine.isolated.back()) + "\"";
    const bool tickless = std::all_of(machine.isolated.begin(), machine.isolated.end(),
                                      [&](int cpu) { return has(machine.tickless, cpu); });
    if (tickless) return finding;
    const std::string cpus = model::cpus_text(machine.isolated);
    finding.severity = Severity::note;
    finding.found += ", but the kernel's timer tick still runs there";
    finding.cure = "boot with isolcpus=" + cpus + " nohz_full=" + cpus + " rcu_nocbs=" + cpus;
    return finding;
  }
  finding.severity = Severity::note;
  finding.found = "no CPU is isolated";
  if (machine.online.size() < 2) {
    finding.found += ", because this machine has only one";
    finding.cure = "use a machine with two or more CPUs";
    return finding;
  }
  const std::string last = std::to_string(trial.cpus.permitted.back());
  finding.cure = "boot with isolcpus=" + last + " nohz_full=" + last + " rcu_nocbs=" + last +
                 ", and give the executor cpu=\"" + last + "\"";
  return finding;
}

Finding interrupts(const Machine& machine, const Trial& trial) {
  Finding finding{.name = "interrupts",
                  .found = "no interrupt arrives on the CPUs of executors",
                  .why = "an interrupt is served before any thread, whatever the thread's priority"};
  const std::vector<int> mine =
      machine.online.size() < 2 ? std::vector<int>{} : os::executor_cpus(machine.isolated, trial.cpus);
  std::vector<std::string> there;
  for (const os::Interrupt& interrupt : machine.interrupts) {
    const bool comes =
        std::any_of(mine.begin(), mine.end(), [&](int cpu) { return has(interrupt.cpus, cpu); });
    if (comes) there.push_back(std::to_string(interrupt.number) + " (" + interrupt.name + ")");
  }
  if (machine.online.size() < 2) finding.found = "all interrupts arrive on the only CPU";
  if (there.empty() && !machine.irqbalance) return finding;
  finding.severity = Severity::note;
  if (!there.empty()) {
    const std::size_t shown = std::min<std::size_t>(there.size(), 4);
    finding.found = there.size() == 1 ? "interrupt " : "interrupts ";
    for (std::size_t i = 0; i < shown; ++i) finding.found += (i == 0 ? "" : ", ") + there[i];
    if (shown < there.size()) finding.found += " and " + std::to_string(there.size() - shown) + " more";
    finding.found += " may arrive on " + model::cpus_in_words(mine);
    finding.cure = "run for irq in /proc/irq/[0-9]*; do echo " +
                   model::cpus_text(without(machine.online, mine)) +
                   " > $irq/smp_affinity_list; done";
  }
  if (machine.irqbalance) {
    finding.found += there.empty() ? ", but irqbalance may move interrupts there"
                                   : "; irqbalance may move more interrupts there";
    finding.cure = "run systemctl disable --now irqbalance" +
                   std::string{there.empty() ? "" : ", and then "} + finding.cure;
  }
  return finding;
}

Finding frequency(const Machine& machine, const Trial&) {
  Finding finding{.name = "frequency",
                  .found = "",
                  .why = "a CPU that was slowed down while it was idle takes time to speed up again"};
  std::string slow;
  bool any = false;
  for (const os::Processor& processor : machine.processors) {
    any |= !processor.governor.empty();
    if (!processor.governor.empty() && processor.governor != "performance") slow = processor.governor;
  }
  finding.found =
      any ? "the frequency governor is performance" : "the kernel does not change the CPU frequency";
  if (slow.empty()) return finding;
  finding.severity = Severity::note;
  finding.found = "the frequency governor is " + slow;
  finding.cure =
      "set it to performance on every CPU, as root: for cpu in /sys/devices/system/cpu/cpu[0-9]*; do echo performance > "
      "$cpu/cpufreq/scaling_governor; done";
  return finding;
}

Finding idle(const Machine& machine, const Trial& trial) {
  Finding finding{.name = "idle states",
                  .found = "no deep idle state is enabled",
                  .why = "the deeper a CPU sleeps, the longer it takes to wake up"};
  const os::IdleState* deepest = nullptr;
  for (const os::Processor& processor : machine.processors) {
    for (const os::IdleState& state : processor.idle_states) {
      if (state.disabled || state.exit_latency <= kDeepIdle) continue;
      if (deepest == nullptr || state.exit_latency > deepest->exit_latency) deepest = &state;
    }
  }
  if (deepest == nullptr) return finding;
  finding.found =
      "a CPU needs " + to_text(deepest->exit_latency) + " to wake up from idle state " + deepest->name;
  if (trial.idle_held) {
    finding.found += "; Takt prevents this idle state while a cell runs";
    return finding;
  }
  finding.severity = Severity::note;
  finding.found += ", and " + in_words(trial.idle_held.problems());
  finding.cure = "run Takt as root, or run chmod a+w /dev/cpu_dma_latency, or boot with cpuidle.off=1";
  return finding;
}

Finding clock(const Machine& machine, const Trial&) {
  Finding finding{.name = "clock",
                  .found = machine.clock.empty() ? "the clock source cannot be read"
                                                 : "the clock source is " + machine.clock,
                  .why =
                      "executors read the time several times in each row; one reading takes 20 ns with a "
                      "fast clock source, but 1 us and a system call with a slow clock source"};
  constexpr const char* kSlow[] = {"hpet", "acpi_pm", "jiffies", "refined-jiffies", "pit", "xen"};
  if (std::none_of(std::begin(kSlow), std::end(kSlow),
                   [&](const char* slow) { return machine.clock == slow; }))
    return finding;
  finding.severity = Severity::spoils;
  const bool tsc = std::find(machine.clocks.begin(), machine.clocks.end(), "tsc") != machine.clocks.end();
  finding.cure = tsc ? "run echo tsc > /sys/devices/system/clocksource/clocksource0/current_clocksource"
                     : "boot with tsc=reliable if the CPU has a constant TSC";
  return finding;
}

Finding wall_clock(const Machine&, const Trial& trial) {
  Finding finding{.name = "wall clock",
                  .found = "nothing synchronises the wall clock of this machine",
                  .why =
                      "the devices of a cell begin at the same time of their wall clocks, and reject a "
                      "deployment if these clocks differ by more than 100 ms"};
  if (trial.wall_clock_error) {
    finding.found =
        "the wall clock is synchronised, with an error of at most " + to_text(*trial.wall_clock_error);
    return finding;
  }
  finding.severity = Severity::note;
  finding.cure =
      "if the cell has devices on several machines, install chrony on each of them, or use ptp4l and phc2sys";
  return finding;
}

Finding timers(const Machine& machine, const Trial& trial) {
  Finding finding{
      .name = "timers",
      .found = "timers have a high resolution",
      .why =
          "timers wake sleeping threads; without a high resolution, a thread is woken only at the next tick"};
  if (trial.timer_resolution >= std::chrono::microseconds{100}) {
    finding.severity = Severity::spoils;
    finding.found = "timers have only the resolution of a tick, " + to_text(trial.timer_resolution);
    finding.cure = "boot a kernel with CONFIG_HIGH_RES_TIMERS and without highres=off";
    return finding;
  }
  if (machine.timer_slack) {
    finding.found +=
        "; their slack of " + to_text(*machine.timer_slack) + " does not affect real-time threads";
  }
  return finding;
}

Finding hyper_threads(const Machine& machine, const Trial&) {
  Finding finding{.name = "hyper-threads",
                  .found = "each CPU has its own core",
                  .why = "two CPUs on one core compete for the execution units and caches of the core"};
  const bool shared =
      std::any_of(machine.processors.begin(), machine.processors.end(),
                  [](const os::Processor& processor) { return processor.siblings.size() > 1; });
  if (!shared) return finding;
  finding.severity = Severity::note;
  for (const os::Processor& processor : machine.processors) {
    if (processor.siblings.size() < 2 || processor.siblings.back() != processor.number) continue;
    finding.found = "CPUs share cores, such as " + model::cpus_in_words(processor.siblings);
  }
  finding.cure = "run echo off > /sys/devices/system/cpu/smt/control";
  return finding;
}

Finding virtual_machine(const Machine& machine, const Trial&) {
  Finding finding{.name = "virtual machine",
                  .found = "this is not a virtual machine",
                  .why = "the host may take a CPU away at any instant, for any length of time"};
  if (machine.hypervisor.empty()) return finding;
  finding.severity = Severity::note;
  finding.found = "this machine runs on " + machine.hypervisor;
  finding.cure = "pin each virtual CPU of this machine to a dedicated CPU, with real-time priority";
  finding.mend_on = kHost;
  return finding;
}

Finding stolen(const Machine& machine, const Trial& trial) {
  Finding finding{.name = "stolen time",
                  .found = "",
                  .why = "during stolen time, the host runs other machines and this machine stands still"};
  if (!machine.time) {
    finding.found = "this kernel does not count stolen time";
    return finding;
  }
  const double ever = machine.time->stolen_share();
  const double now = trial.stolen_share.value_or(0);
  finding.found = percent(ever) + " of the time since the boot was stolen, " + percent(now) + " at present";
  // The present share of stolen time changes every second. So even a high present share causes only a note.
  if (ever >= kStolenSpoils)
    finding.severity = Severity::spoils;
  else if (now >= kStolenNote || ever >= kStolenNote)
    finding.severity = Severity::note;
  if (finding.severity == Severity::good) return finding;
  finding.cure = "give this machine dedicated CPUs: pin its virtual CPUs, and keep other work off these CPUs";
  finding.mend_on = kHost;
  return finding;
}

Finding huge_pages(const Machine& machine, const Trial&) {
  Finding finding{
      .name = "huge pages",
      .found = machine.huge_pages.empty() ? "this kernel has no transparent huge pages"
                                          : "transparent huge pages are set to " + machine.huge_pages,
      .why = "with the setting always, the kernel rearranges a program's pages while the program runs"};
  if (machine.huge_pages == "always") {
    finding.severity = Severity::note;
    finding.cure = "run echo madvise > /sys/kernel/mm/transparent_hugepage/enabled";
  }
  if (machine.numa_balancing.value_or(false)) {
    finding.severity = Severity::note;
    finding.found += "; the kernel moves pages between memory nodes (numa_balancing)";
    finding.cure +=
        (finding.cure.empty() ? "" : ", and ") + std::string{"run sysctl -w kernel.numa_balancing=0"};
  }
  return finding;
}

Finding sockets(const Machine& machine, const Trial&) {
  Finding finding{
      .name = "sockets",
      .found = "",
      .why =
          "if the samples of a burst do not fit into the socket buffer, some are lost, or sent again later"};
  const std::uint64_t receive = machine.receive_buffer_bytes.value_or(0);
  const std::uint64_t send = machine.send_buffer_bytes.value_or(0);
  finding.found = "a socket's receive buffer may have up to " + amount(receive) + ", its send buffer up to " +
                  amount(send);
  if (!machine.receive_buffer_bytes || !machine.send_buffer_bytes)
    finding.found = "the limits of socket buffers cannot be read";
  if (!machine.receive_buffer_bytes || (receive >= kSocketBuffer && send >= kSocketBuffer)) return finding;
  finding.severity = Severity::note;
  finding.cure = "run sysctl -w net.core.rmem_max=4194304 net.core.wmem_max=4194304";
  return finding;
}

Finding components(const Machine& machine, const Trial&) {
  Finding finding{.name = "components",
                  .found = "the kernel allows code to be executed from copies in memory",
                  .why = "Takt loads each .so, and starts each signed program, from a copy in memory"};
  if (machine.memfd_noexec.value_or(0) < 2) return finding;
  finding.severity = Severity::spoils;
  finding.found = "no .so can be loaded, because the kernel setting vm.memfd_noexec is 2";
  finding.cure = "run sysctl -w vm.memfd_noexec=1";
  return finding;
}

Finding files(const Machine& machine, const Trial&) {
  Finding finding{.name = "files",
                  .found = "no limit on open files is known",
                  .why = "each program of a cell and each of its connections needs some open files"};
  if (!machine.files) return finding;
  finding.found = "the limit of open files in a process is " + limit_text(machine.files->hard);
  if (!machine.files->hard || *machine.files->hard >= kFiles) return finding;
  finding.severity = Severity::note;
  finding.cure = "run echo '* - nofile 65536' >> /etc/security/limits.conf";
  return finding;
}

Finding shared_memory(const Machine& machine, const Trial&) {
  Finding finding{
      .name = "shared memory",
      .found = "",
      .why =
          "Takt's own shared memory does not use /dev/shm, but other DDS programs on this machine may "
          "need it"};
  finding.found = machine.shared_memory_bytes ? "/dev/shm has " + amount(*machine.shared_memory_bytes)
                                              : "there is no /dev/shm";
  if (machine.shared_memory_bytes.value_or(0) >= 64 * kMiB) return finding;
  finding.severity = Severity::note;
  finding.cure = "run mount -o remount,size=256M /dev/shm";
  return finding;
}

Finding wake_up(const Machine&, const Trial& trial) {
  const os::WakeUps& w = trial.wake_ups;
  Finding finding{
      .name = "wake-up",
      .found = std::to_string(w.count) + " wake-ups " +
               (trial.priority ? "under SCHED_FIFO" : "without SCHED_FIFO") + " were late by p50 " +
               microseconds(w.p50) + ", p99 " + microseconds(w.p99) + ", max " + microseconds(w.max),
      .why = "this is the combined effect of all other findings: how late a sleeping thread wakes up"};
  if (w.count == 0) {
    finding.severity = Severity::spoils;
    finding.found = "wake-ups could not be measured, because no thread could be started";
    finding.cure = "free memory, or raise the limit on threads";
  } else if (w.p99 > kLateNote && !trial.priority && trial.node_is_real_time) {
    finding.severity = Severity::note;
    finding.found += "; this does not hold for takt-node, which is granted SCHED_FIFO";
    finding.cure = "run takt doctor as root to measure wake-ups under SCHED_FIFO";
  } else if (w.p99 > kLateSpoils) {
    finding.severity = Severity::spoils;
    finding.cure = "correct the other findings, and run takt doctor again";
  } else if (w.p99 > kLateNote || w.max > kRarelyLateNote) {
    finding.severity = Severity::note;
    finding.cure = "correct the other findings, and run takt doctor again";
  }
  return finding;
}

// True if the finding is about a setting of the kernel, which a container cannot change.
bool is_of_the_kernel(const Finding& finding) {
  return finding.name != "priority" && finding.name != "memory" && finding.name != "files" &&
         finding.name != "shared memory" && finding.name != "wake-up";
}

}  // namespace

const char* to_text(Severity severity) noexcept {
  switch (severity) {
    case Severity::good:
      return "good";
    case Severity::note:
      return "note";
    case Severity::spoils:
      break;
  }
  return "spoils";
}

std::vector<Finding> diagnose(const Machine& machine, const Trial& trial) {
  std::vector<Finding> findings;
  for (const auto check :
       {preemption, priority, memory, swap, throttling, cpu_limit, isolation, interrupts, frequency, idle, clock, wall_clock,
        timers, hyper_threads, virtual_machine, stolen, huge_pages, sockets, components, files, shared_memory, wake_up}) {
    Finding finding = check(machine, trial);
    // The kernel's settings cannot be changed inside a sealed container, so the cure must be applied on the
    // machine outside the container.
    if (!machine.container.empty() && machine.sealed && !finding.cure.empty() && finding.mend_on.empty() &&
        is_of_the_kernel(finding)) {
      finding.mend_on = "the machine that this container runs on";
    }
    findings.push_back(std::move(finding));
  }
  return findings;
}

}  // namespace takt::node
