// What a machine is like as far as real time goes, read from /proc and /sys. Reading and nothing else: what
// of it is good or bad is for others to say. A value that cannot be read (no such file on this kernel, or not
// for this user) is absent, which is not the same as 0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::os {

/// How soon a thread in the kernel gives way to one of higher priority.
enum class Preemption { none, voluntary, lazy, full, real_time };
const char* to_text(Preemption preemption) noexcept;

/// What the kernel keeps from real-time threads that never sleep: `kept` of each `period`. Up to Linux 6.11
/// by real-time throttling (/proc/sys/kernel/sched_rt_runtime_us), later by a server of ordinary threads on
/// each processor (/sys/kernel/debug/sched/fair_server), which that file does not switch off.
struct Throttling {
  Nanoseconds kept{};
  Nanoseconds period{std::chrono::seconds{1}};
  bool fair_server = false;
  bool seen = true;  ///< false: it may not be read, and these are the kernel's own values

  [[nodiscard]] bool on() const noexcept { return kept > Nanoseconds{0}; }
};

struct IdleState {
  std::string name;
  Nanoseconds exit_latency{};
  bool disabled = false;
};

struct Processor {
  int number = 0;
  std::string governor{};                ///< of its frequency; empty: none
  std::vector<IdleState> idle_states{};  ///< shallow to deep
  std::vector<int> siblings{};           ///< that share its core, itself too
};

struct Interrupt {
  int number = 0;
  std::string name{};       ///< of the device; empty: nobody serves it
  std::vector<int> cpus{};  ///< that it may come to
};

/// A resource limit; `hard` is how far this user may raise it. Absent: unlimited.
struct Limit {
  std::optional<std::uint64_t> soft{};
  std::optional<std::uint64_t> hard{};
};

/// What the processors did since the machine was started, in ticks.
struct ProcessorTime {
  std::uint64_t all = 0;
  std::uint64_t stolen = 0;  ///< the host of this virtual machine ran somebody else

  /// As a share from 0 to 1: of the time since `before`, or of all.
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
  std::vector<int> online{};        ///< processors
  std::vector<int> isolated{};      ///< from the kernel's scheduler
  std::vector<int> tickless{};      ///< nohz_full
  std::vector<Processor> processors{};
  std::optional<bool> hyper_threads{};  ///< hyper-threading is active
  std::string clock{};                  ///< the clock source: "tsc"
  std::vector<std::string> clocks{};    ///< that it could be
  std::vector<Interrupt> interrupts{};  ///< that somebody serves
  bool irqbalance = false;              ///< runs
  std::optional<Nanoseconds> timer_slack{};
  std::optional<std::uint64_t> swap_bytes{};
  std::optional<std::uint64_t> shared_memory_bytes{};   ///< of /dev/shm
  std::optional<std::uint64_t> receive_buffer_bytes{};  ///< net.core.rmem_max
  std::optional<std::uint64_t> send_buffer_bytes{};     ///< net.core.wmem_max
  std::string huge_pages{};                             ///< "always", "madvise", "never"
  std::optional<bool> numa_balancing{};
  std::string hypervisor{};  ///< "a hypervisor" or its product; empty: none is seen
  std::string container{};   ///< the file that gives it away; empty: none
  bool sealed = false;       ///< what the kernel can be told (/proc/sys) is read-only here
  std::optional<ProcessorTime> time{};
};

/// Reads what there is below `root`: "" is this machine, anything else a tree of copies. Never fails.
Machine read_machine(const std::string& root = {});

/// The parts of it that are looked at alone.
std::optional<Throttling> read_throttling(const std::string& root = {});
std::optional<ProcessorTime> read_processor_time(const std::string& root = {});
std::optional<std::uint64_t> read_swap_bytes(const std::string& root = {});

/// "0-2,5" as the kernel writes lists of processors; what is no such list is empty.
std::vector<int> parse_cpus(const std::string& text);
/// The other way round.
std::string cpus_text(const std::vector<int>& cpus);

}  // namespace takt::os
