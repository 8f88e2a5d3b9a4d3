// Describes the machine on which a benchmark runs, and measures how much CPU time and memory were used.
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
  std::string clock_source;  ///< for example "tsc", which is read without a system call
  std::string governor;  ///< frequency governor of CPU 0, for example "performance"; empty if no frequency
                         ///< scaling is visible
  std::string isolated;  ///< the CPUs that are kept free of other programs, for example "2-3"; empty if there
                         ///< are none
  bool hypervisor = false;  ///< true for a virtual machine, whose CPUs the host may use for other work
  double throttled = 0;  ///< share of each second that the kernel withholds from real-time threads that never
                         ///< sleep; 0 to 1
  std::string load;      ///< average load of the last 1, 5 and 15 minutes, for example "0.52 0.58 0.59"
};

/// Describes this machine. Reads files of /proc and /sys; not for real-time threads.
Platform describe_platform();

/// The CPU time that other virtual machines on the same hardware took from all CPUs of this machine since it
/// was started, usually in steps of 10 ms. Not for real-time threads.
Nanoseconds stolen_time();

/// The memory in bytes that a process uses, including its share of shared memory (proportional set size); 0
/// if it cannot be read. Not for real-time threads.
std::uint64_t memory_of(int pid);

/// The CPU time that the calling thread has used. At most one system call.
Nanoseconds thread_time() noexcept;

}  // namespace takt::os
