// Reads the properties of a machine that matter for real time, from /proc and /sys. The node judges these
// properties. A value is absent if it cannot be read, because the kernel has no such file or this user may
// not read it. An absent value does not mean 0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/model/cpus.hpp>

namespace takt::os {

/// In which places the kernel preempts a thread that executes kernel code.
enum class Preemption { none, voluntary, lazy, full, real_time };
const char* to_text(Preemption preemption) noexcept;

/// The CPU time that the kernel withholds from real-time threads that never sleep: `kept` in each `period`.
/// Up to Linux 6.11, the kernel does this by real-time throttling (/proc/sys/kernel/sched_rt_runtime_us).
/// Later kernels have a server for ordinary threads on each CPU (/sys/kernel/debug/sched/fair_server), which
/// sched_rt_runtime_us does not switch off.
struct Throttling {
  Nanoseconds kept{};
  Nanoseconds period{std::chrono::seconds{1}};
  bool fair_server = false;
  bool seen = true;  ///< false if the values cannot be read and are the kernel's defaults instead

  [[nodiscard]] bool on() const noexcept { return kept > Nanoseconds{0}; }
};

struct IdleState {
  std::string name;
  Nanoseconds exit_latency{};
  bool disabled = false;
};

/// A logical CPU.
struct Processor {
  int number = 0;
  std::string governor{};                ///< the governor of its frequency; empty if there is none
  std::vector<IdleState> idle_states{};  ///< from the shallowest to the deepest
  std::vector<int> siblings{};           ///< the CPUs of the same core, including this one
};

struct Interrupt {
  int number = 0;
  std::string name{};       ///< name of the interrupt's handler, usually the device
  std::vector<int> cpus{};  ///< the CPUs on which the kernel may handle the interrupt
};

/// A resource limit. A process of this user may raise `soft` up to `hard`. An absent `soft` or `hard` means
/// that there is no limit.
struct Limit {
  std::optional<std::uint64_t> soft{};
  std::optional<std::uint64_t> hard{};
};

/// The CPU time of all CPUs together since the machine was started, in ticks of the kernel.
struct ProcessorTime {
  std::uint64_t all = 0;
  std::uint64_t stolen = 0;  ///< the time in which the hypervisor of this virtual machine did other work

  /// Returns the share of the time that was stolen since `before`, or since the start of the machine; from 0
  /// to 1.
  [[nodiscard]] double stolen_share(const ProcessorTime& before) const noexcept;
  [[nodiscard]] double stolen_share() const noexcept { return stolen_share({}); }
};

struct Machine {
  std::string kernel{};   ///< release of the kernel, for example "6.1.0-31-rt-amd64"
  std::string version{};  ///< version of the kernel, for example "#1 SMP PREEMPT_RT Debian 6.1.128-1"
  std::optional<Preemption> preemption{};
  std::optional<Throttling> throttling{};
  /// RLIMIT_RTPRIO: the highest real-time priority of this user's processes.
  std::optional<Limit> priority{};
  std::optional<Limit> locked{};  ///< RLIMIT_MEMLOCK, in bytes
  std::optional<Limit> files{};   ///< RLIMIT_NOFILE: the number of open files of a process
  std::vector<int> online{};      ///< all CPUs that are online
  std::vector<int> isolated{};    ///< CPUs that are isolated from the kernel's scheduler
  std::vector<int> tickless{};    ///< CPUs on which the kernel's timer tick stops (nohz_full)
  std::vector<Processor> processors{};
  std::optional<bool> hyper_threads{};  ///< true if hyper-threading is active
  std::string clock{};                  ///< the current clock source, for example "tsc"
  std::vector<std::string> clocks{};    ///< the available clock sources
  std::vector<Interrupt> interrupts{};  ///< the interrupts that have a handler
  bool irqbalance = false;              ///< true if irqbalance runs
  std::optional<Nanoseconds> timer_slack{};
  std::optional<std::uint64_t> swap_bytes{};
  std::optional<std::uint64_t> shared_memory_bytes{};  ///< size of /dev/shm
  /// The kernel setting net.core.rmem_max: the maximum size of a socket's receive buffer.
  std::optional<std::uint64_t> receive_buffer_bytes{};
  /// The kernel setting net.core.wmem_max: the maximum size of a socket's send buffer.
  std::optional<std::uint64_t> send_buffer_bytes{};
  std::string huge_pages{};  ///< "always", "madvise" or "never"
  std::optional<bool> numa_balancing{};
  /// The kernel setting vm.memfd_noexec. If it is 2, no code in memory that belongs to no file can be
  /// executed.
  std::optional<int> memfd_noexec{};
  std::string hypervisor{};  ///< name of the hypervisor's product, or "a hypervisor"; empty if none was
                             ///< detected
  /// The file that shows that this machine is a container, for example "/.dockerenv"; empty if it is none.
  std::string container{};
  bool sealed = false;  ///< true if the kernel's settings (/proc/sys) are read-only, as in some containers
  std::optional<ProcessorTime> time{};
};

/// Reads the properties of a machine from the files below the folder `root`. If `root` is empty, reads those
/// of this machine; otherwise `root` contains copies of such files. Never fails.
Machine read_machine(const std::string& root = {});

/// Each of these functions reads only one property of the machine. `root` means the same as in
/// read_machine().
std::optional<Throttling> read_throttling(const std::string& root = {});
std::optional<ProcessorTime> read_processor_time(const std::string& root = {});
std::optional<std::uint64_t> read_swap_bytes(const std::string& root = {});
std::vector<int> read_isolated_cpus(const std::string& root = {});

/// Reads the CPUs of this machine, and tries on which of them the kernel lets a thread of this process run.
/// `ordinary` contains the CPUs of the calling thread. Starts a thread for the trial.
model::Cpus read_cpus();

/// Converts a list of CPUs in the kernel's form, for example "0-2,5", to numbers. Returns an empty list if
/// the text does not have this form.
std::vector<int> parse_cpus(const std::string& text);

}  // namespace takt::os
