// Reads the properties of a machine that matter for real time, from /proc and /sys. This room does not judge
// the properties. A value that cannot be read (the kernel has no such file, or this user may not read it) is
// absent, which differs from 0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::os {

/// How the kernel preempts a thread that runs in the kernel.
enum class Preemption { none, voluntary, lazy, full, real_time };
const char* to_text(Preemption preemption) noexcept;

/// The time that the kernel withholds from real-time threads that never sleep: `kept` of each `period`. Up to
/// Linux 6.11 this is real-time throttling (/proc/sys/kernel/sched_rt_runtime_us). Later kernels have a
/// server for ordinary threads on each CPU (/sys/kernel/debug/sched/fair_server). The file
/// sched_rt_runtime_us does not switch off this server.
struct Throttling {
  Nanoseconds kept{};
  Nanoseconds period{std::chrono::seconds{1}};
  bool fair_server = false;
  bool seen = true;  ///< false: not readable, these are the kernel's defaults

  [[nodiscard]] bool on() const noexcept { return kept > Nanoseconds{0}; }
};

struct IdleState {
  std::string name;
  Nanoseconds exit_latency{};
  bool disabled = false;
};

/// A CPU.
struct Processor {
  int number = 0;
  std::string governor{};                ///< of its frequency; empty: none
  std::vector<IdleState> idle_states{};  ///< from shallow to deep
  std::vector<int> siblings{};           ///< the CPUs of its core, including itself
};

struct Interrupt {
  int number = 0;
  std::string name{};       ///< of the device; empty: no handler
  std::vector<int> cpus{};  ///< the CPUs that may handle it
};

/// A resource limit. This user may raise it up to `hard`. An absent value means that there is no limit.
struct Limit {
  std::optional<std::uint64_t> soft{};
  std::optional<std::uint64_t> hard{};
};

/// The time of all CPUs since the machine was started, in ticks.
struct ProcessorTime {
  std::uint64_t all = 0;
  std::uint64_t stolen = 0;  ///< the host of this virtual machine ran something else

  /// The stolen share of the time since `before`, or of all time; 0 to 1.
  [[nodiscard]] double stolen_share(const ProcessorTime& before) const noexcept;
  [[nodiscard]] double stolen_share() const noexcept { return stolen_share({}); }
};

struct Machine {
  std::string kernel{};   ///< its release: "6.1.0-31-rt-amd64"
  std::string version{};  ///< "#1 SMP PREEMPT_RT Debian 6.1.128-1"
  std::optional<Preemption> preemption{};
  std::optional<Throttling> throttling{};
  std::optional<Limit> priority{};  ///< RLIMIT_RTPRIO
  std::optional<Limit> locked{};    ///< RLIMIT_MEMLOCK, in bytes
  std::optional<Limit> files{};     ///< RLIMIT_NOFILE
  std::vector<int> online{};        ///< CPUs
  std::vector<int> isolated{};      ///< from the kernel's scheduler
  std::vector<int> tickless{};      ///< nohz_full
  std::vector<Processor> processors{};
  std::optional<bool> hyper_threads{};  ///< hyper-threading is active
  std::string clock{};                  ///< the clock source: "tsc"
  std::vector<std::string> clocks{};    ///< the available clock sources
  std::vector<Interrupt> interrupts{};  ///< with a handler
  bool irqbalance = false;              ///< whether irqbalance runs
  std::optional<Nanoseconds> timer_slack{};
  std::optional<std::uint64_t> swap_bytes{};
  std::optional<std::uint64_t> shared_memory_bytes{};   ///< of /dev/shm
  std::optional<std::uint64_t> receive_buffer_bytes{};  ///< net.core.rmem_max
  std::optional<std::uint64_t> send_buffer_bytes{};     ///< net.core.wmem_max
  std::string huge_pages{};                             ///< "always", "madvise", "never"
  std::optional<bool> numa_balancing{};
  std::string hypervisor{};  ///< "a hypervisor" or its product name; empty: none detected
  std::string container{};   ///< the file that indicates a container; empty: none
  bool sealed = false;       ///< the kernel's settings (/proc/sys) are read-only here
  std::optional<ProcessorTime> time{};
};

/// Reads the properties of a machine from the files below `root`. An empty `root` means this machine; any
/// other `root` is a tree of copied files. Never fails.
Machine read_machine(const std::string& root = {});

/// These functions read single parts of the machine.
std::optional<Throttling> read_throttling(const std::string& root = {});
std::optional<ProcessorTime> read_processor_time(const std::string& root = {});
std::optional<std::uint64_t> read_swap_bytes(const std::string& root = {});

/// Reads a list of CPUs as the kernel writes it: "0-2,5". Empty if the text is not such a list.
std::vector<int> parse_cpus(const std::string& text);
/// Writes such a list.
std::string cpus_text(const std::vector<int>& cpus);

}  // namespace takt::os
