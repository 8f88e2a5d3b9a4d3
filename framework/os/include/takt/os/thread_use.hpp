// The kernel's counters for a thread and for a CPU, which show what kept a thread from running. These
// functions read /proc, and are not for real-time threads.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::os {

/// The counters of a thread since the thread was started.
struct ThreadUse {
  std::uint64_t minor_faults = 0;  ///< page faults that did not read from a disk
  std::uint64_t major_faults = 0;  ///< page faults that read from a disk
  std::uint64_t gave_way = 0;      ///< number of times that the thread was preempted
  Nanoseconds waited{};  ///< total time in which the thread was ready but had no CPU; 0 if the kernel does
                         ///< not measure it
  std::optional<Nanoseconds> ran{};  ///< total time on a CPU, which the kernel updates at its timer tick;
                                     ///< none if the kernel does not measure it
  int cpu = -1;                      ///< the CPU on which the thread ran last; -1 if not known
  bool ready = false;                ///< true if the thread is running, or is ready but has no CPU
  bool stopped = false;              ///< true if a signal or a debugger has stopped the thread
};

/// Reads the counters of a thread of any process. Returns none if there is no such thread. `root` means the
/// same as in read_machine().
std::optional<ThreadUse> read_thread_use(int tid, const std::string& root = {});

/// Returns, by CPU number, the time that the hypervisor has taken from each CPU since the machine was
/// started, usually in steps of 10 ms. Empty if it cannot be read.
std::vector<Nanoseconds> read_stolen(const std::string& root = {});

/// Measures the shortest time that a page fault takes on this machine if the fault does not read from a disk.
/// This time is below a microsecond on a physical machine, and up to about 10 us in a virtual machine. The
/// measurement takes some milliseconds.
Nanoseconds measure_minor_fault();

}  // namespace takt::os
