// Reads the properties of a machine that matter for real time, from /proc and /sys. The node judges these
// properties. A value that cannot be read, because the kernel has no such file or this user may not read it,
// is absent. An absent value is not the same as 0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::os {

/// Whether and when the kernel preempts a thread that executes kernel code.
enum class Preemption { none, voluntary, lazy, full, real_time };
const char* to_text(Preemption preemption) noexcept;

/// The CPU time that the kernel withholds from real-time threads that never sleep: `kept` of each `period`.
/// Up to Linux 6.11 this is real-time throttling (/proc/sys/kernel/sched_rt_runtime_us). Later kernels have a
/// server for ordinary threads on each CPU (/sys/kernel/debug/sched/fair_server), which sched_rt_runtime_us
/// does not switch off.
struct Throttling {
  Nanoseconds kept{};
  Nanoseconds period{std::chrono::seconds{1}};
  bool fair_server = false;
  bool seen = true;  ///< false: the values cannot be read, and the defaults of the kernel are assumed

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
  std::string name{};       ///< name of the device; empty if no handler is installed
  std::vector<int> cpus{};  ///< the CPUs that may handle it
};

/// A resource limit. A process of this user may raise `soft` up to `hard`. An absent value means that there
/// is no limit.
struct Limit {
  std::optional<std::uint64_t> soft{};
  std::optional<std::uint64_t> hard{};
};

/// The time in ticks that all CPUs have counted since the machine was started.
struct ProcessorTime {
  std::uint64_t all = 0;
  std::uint64_t stolen = 0;  ///< the time that the host of this virtual machine gave to other work

  /// The stolen share of the time since `before`, or of all time; from 0 to 1.
  [[nodiscard]] double stolen_share(const ProcessorTime& before) const noexcept;
  [[nodiscard]] double stolen_share() const noexcept { return stolen_share({}); }
};

struct Machine {
  std::string kernel{};   ///< release of the kernel, for example "6.1.0-31-rt-amd64"
  std::string version{};  ///< version of the kernel, for example "#1 SMP PREEMPT_RT Debian 6.1.128-1"
  std::optional<Preemption> preemption{};
  std::optional<Throttling> throttling{};
  std::optional<Limit> priority{};  ///< RLIMIT_RTPRIO
  std::optional<Limit> locked{};    ///< RLIMIT_MEMLOCK, in bytes
  std::optional<Limit> files{};     ///< RLIMIT_NOFILE
  std::vector<int> online{};        ///< CPUs
  std::vector<int> isolated{};      ///< CPUs that are isolated from the kernel's scheduler
  std::vector<int> tickless{};      ///< nohz_full
  std::vector<Processor> processors{};
  std::optional<bool> hyper_threads{};  ///< true if hyper-threading is active
  std::string clock{};                  ///< the current clock source, for example "tsc"
  std::vector<std::string> clocks{};    ///< the available clock sources
  std::vector<Interrupt> interrupts{};  ///< the interrupts that have a handler
  bool irqbalance = false;              ///< true if irqbalance runs
  std::optional<Nanoseconds> timer_slack{};
  std::optional<std::uint64_t> swap_bytes{};
  std::optional<std::uint64_t> shared_memory_bytes{};   ///< of /dev/shm
  std::optional<std::uint64_t> receive_buffer_bytes{};  ///< net.core.rmem_max
  std::optional<std::uint64_t> send_buffer_bytes{};     ///< net.core.wmem_max
  std::string huge_pages{};                             ///< "always", "madvise" or "never"
  std::optional<bool> numa_balancing{};
  std::string hypervisor{};  ///< name of the hypervisor's product, or "a hypervisor"; empty if none was
                             ///< detected
  std::string container{};   ///< the file that indicates a container; empty if there is none
  bool sealed = false;       ///< true if the kernel's settings (/proc/sys) are read-only here
  std::optional<ProcessorTime> time{};
};

/// Reads the properties of a machine from the files below `root`. An empty `root` stands for this machine;
/// any other `root` is a folder with copied files. Never fails.
Machine read_machine(const std::string& root = {});

/// Each of these functions reads only one of the properties.
std::optional<Throttling> read_throttling(const std::string& root = {});
std::optional<ProcessorTime> read_processor_time(const std::string& root = {});
std::optional<std::uint64_t> read_swap_bytes(const std::string& root = {});

/// Converts a list of CPUs in the form of the kernel, for example "0-2,5". Returns an empty list if the text
/// does not have this form.
std::vector<int> parse_cpus(const std::string& text);
/// Writes a list of CPUs in the same form.
std::string cpus_text(const std::vector<int>& cpus);

}  // namespace takt::os
