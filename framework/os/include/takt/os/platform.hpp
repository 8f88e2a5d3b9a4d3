// Describes the machine of a measurement, and measures the CPU time and memory that were used.
#pragma once

#include <cstdint>
#include <string>

#include <takt/core/time.hpp>

namespace takt::os {

/// The current state of the machine. Values that Linux does not provide are empty.
struct Platform {
  std::string name;
  std::string processor;     ///< "Intel(R) Core(TM) i7-7700 CPU @ 3.60GHz"
  int processors = 0;        ///< the number of online CPUs
  std::string kernel;        ///< "6.1.0-18-rt-amd64 #1 SMP PREEMPT_RT ..."
  std::string clock_source;  ///< "tsc": read without a system call
  std::string governor;      ///< of CPU 0: "performance"; empty: no frequency scaling is visible
  std::string isolated;      ///< "2-3": the CPUs kept free of other programs; empty: none
  bool hypervisor = false;   ///< a virtual machine, whose CPUs may be taken away by the host
  double throttled = 0;  ///< share of each second withheld from real-time threads that never sleep; 0 to 1
  std::string load;      ///< "0.52 0.58 0.59": the load of the last 1, 5 and 15 minutes
};

/// Reads files of /proc and /sys; not for real-time threads.
Platform describe_platform();

/// The time that other virtual machines on the same hardware took from all CPUs of this machine since its
/// start, usually in steps of 10 ms. Not for real-time threads.
Nanoseconds stolen_time();

/// The memory of a process in bytes, including its share of shared memory (proportional set size); 0 if it
/// cannot be read. Not for real-time threads.
std::uint64_t memory_of(int pid);

/// The CPU time that the calling thread has used. At most one system call.
Nanoseconds thread_time() noexcept;

}  // namespace takt::os
