// Describes the machine on which a benchmark runs, and measures CPU time and memory use.
#pragma once

#include <cstdint>
#include <string>

#include <takt/core/time.hpp>

namespace takt::os {

/// A description of the machine and its current state. Values that Linux does not provide are empty.
struct Platform {
  std::string name;
  std::string processor;     ///< for example "Intel(R) Core(TM) i7-7700 CPU @ 3.60GHz"
  int processors = 0;        ///< number of online CPUs
  std::string kernel;        ///< for example "6.1.0-18-rt-amd64 #1 SMP PREEMPT_RT ..."
  std::string clock_source;  ///< the clock source, for example "tsc", which a process can read without a
                             ///< system call
  std::string governor;  ///< frequency governor of CPU 0, for example "performance"; empty if no frequency
                         ///< scaling is visible
  /// The CPUs that the kernel keeps free of other threads (isolcpus), for example "2-3"; empty if there are
  /// none.
  std::string isolated;
  bool hypervisor = false;  ///< true for a virtual machine; the hypervisor may use its CPUs for other work
  double throttled = 0;  ///< share of each second that the kernel withholds from real-time threads that never
                         ///< sleep; 0 to 1
  std::string load;      ///< average load of the last 1, 5 and 15 minutes, for example "0.52 0.58 0.59"
};

/// Describes this machine, from files of /proc and /sys. Not for real-time threads.
Platform describe_platform();

/// Returns the CPU time that the hypervisor has taken from all CPUs of this machine since the machine was
/// started, usually in steps of 10 ms. Not for real-time threads.
Nanoseconds stolen_time();

/// Returns the memory in bytes that a process uses, including its share of shared memory (proportional set
/// size); 0 if it cannot be read. Not for real-time threads.
std::uint64_t memory_of(int pid);

/// Returns the CPU time that the calling thread has used. At most one system call.
Nanoseconds thread_time() noexcept;

}  // namespace takt::os
