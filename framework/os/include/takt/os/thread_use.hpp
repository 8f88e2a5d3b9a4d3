// The kernel's counters of a thread and of a CPU, which show what kept a thread from running. Reads /proc;
// not for real-time threads.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::os {

/// Since the thread was started.
struct ThreadUse {
  std::uint64_t minor_faults = 0;  ///< pages that were given to it
  std::uint64_t major_faults = 0;  ///< of these, that had to be read from a disk
  std::uint64_t gave_way = 0;      ///< times that another thread took its processor
  Nanoseconds waited{};  ///< for a processor while it could have run; 0 where the kernel does not count it
  int cpu = -1;          ///< the processor that it ran on last
  bool stopped = false;  ///< by a signal or a debugger, at present
};

/// Of a thread of any process; none where there is none. `root` as in read_machine().
std::optional<ThreadUse> read_thread_use(int tid, const std::string& root = {});

/// What the hypervisor took from each processor since the machine was started, by its number; in steps of 10
/// ms as a rule. Empty where it cannot be read.
std::vector<Nanoseconds> read_stolen(const std::string& root = {});

}  // namespace takt::os
