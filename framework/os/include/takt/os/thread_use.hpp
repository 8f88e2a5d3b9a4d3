// The kernel's counters of a thread and of a CPU, which show what kept a thread from running. Reads /proc;
// not for real-time threads.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::os {

/// The counters of a thread since it was started.
struct ThreadUse {
  std::uint64_t minor_faults = 0;  ///< page faults that needed no disk
  std::uint64_t major_faults = 0;  ///< page faults that read from a disk
  std::uint64_t gave_way = 0;      ///< times that another thread took its CPU
  Nanoseconds waited{};  ///< time in which it was ready but had no CPU; 0 if the kernel does not count it
  int cpu = -1;          ///< the CPU on which it ran last
  bool stopped = false;  ///< a signal or a debugger has stopped it at present
};

/// Reads the counters of a thread of any process; none if there is no such thread. `root` as in
/// read_machine().
std::optional<ThreadUse> read_thread_use(int tid, const std::string& root = {});

/// The time that the hypervisor took from each CPU since the machine was started, indexed by CPU number;
/// usually in steps of 10 ms. Empty if it cannot be read.
std::vector<Nanoseconds> read_stolen(const std::string& root = {});

}  // namespace takt::os
