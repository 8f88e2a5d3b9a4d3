// What something was measured on, without which a number says nothing, and what it took.
#pragma once

#include <cstdint>
#include <string>

#include <takt/core/time.hpp>

namespace takt::os {

/// As it is now. What Linux does not say is empty.
struct Platform {
  std::string name;
  std::string processor;     ///< "Intel(R) Core(TM) i7-7700 CPU @ 3.60GHz"
  int processors = 0;        ///< that are online
  std::string kernel;        ///< "6.1.0-18-rt-amd64 #1 SMP PREEMPT_RT ..."
  std::string clock_source;  ///< "tsc": read without a system call
  std::string governor;      ///< of processor 0: "performance"; empty: no frequency scaling is to be seen
  std::string isolated;      ///< "2-3": kept free from other programs; empty: none
  bool hypervisor = false;   ///< it is a virtual machine, whose processors others may take away
  double throttled = 0;      ///< of each second, taken from real-time threads that never sleep; 0 to 1
  std::string load;          ///< "0.52 0.58 0.59": of the last 1, 5 and 15 minutes
};

/// Reads files of /proc and /sys; not for real-time threads.
Platform describe_platform();

/// What other machines on the same hardware took from all processors of this one, since it was started. In
/// steps of 10 ms as a rule. Not for real-time threads.
Nanoseconds stolen_time();

/// The memory of a process in bytes, of what it shares with others its part (proportional set size); 0 where
/// that may not be read. Not for real-time threads.
std::uint64_t memory_of(int pid);

/// The processor time that the calling thread has used. One system call at most.
Nanoseconds thread_time() noexcept;

}  // namespace takt::os
