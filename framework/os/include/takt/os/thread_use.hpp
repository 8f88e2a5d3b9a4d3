// The kernel's counters for a thread and for a CPU, which show what kept a thread from running. The functions
// read /proc and are not for real-time threads.
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
  std::uint64_t gave_way = 0;      ///< how often another thread took the CPU from this one
  Nanoseconds waited{};  ///< total time in which the thread was ready but had no CPU; 0 if the kernel does
                         ///< not measure it
  int cpu = -1;          ///< the CPU on which it ran last
  bool stopped = false;  ///< true if a signal or a debugger has stopped the thread
};

/// Reads the counters of a thread of any process. Returns none if there is no such thread. For `root`, see
/// read_machine().
std::optional<ThreadUse> read_thread_use(int tid, const std::string& root = {});

/// The time that the hypervisor has taken from each CPU since the machine was started, usually in steps of 10
/// ms. Indexed by CPU number. Empty if it cannot be read.
std::vector<Nanoseconds> read_stolen(const std::string& root = {});

}  // namespace takt::os
