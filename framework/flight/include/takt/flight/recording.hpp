// A recording of the last few seconds of a device: the actions of its executors, and the kernel's counters
// for their threads.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/channel/activity.hpp>
#include <takt/channel/flight_record.hpp>
#include <takt/core/time.hpp>
#include <takt/os/thread_use.hpp>

namespace takt::flight {

struct Module {
  std::string name;
  bool process = false;
  Nanoseconds budget{};              ///< the maximum duration of one run(); 0: no budget
  std::vector<std::string> ports{};  ///< names of the module's ports, in order; empty if unknown
};

/// The activity of a thread at one instant: when the recording was made, or when the thread's host died.
struct Open {
  std::uint32_t module = 0;
  channel::Doing doing = channel::Doing::nothing;
  std::int64_t since_ns = 0;
  std::int64_t seen_ns = 0;
  bool host_died = false;
};

/// One thread of an executor. It runs either the rows or the sporadic modules.
struct Thread {
  channel::FlightCopy copy{};
  /// One entry for each host that died while this thread was busy, and one for the activity at the time of
  /// the recording.
  std::vector<Open> open{};
};

struct Executor {
  std::string name;
  Nanoseconds basic_period{};
  std::array<Thread, 2> threads{};  ///< the thread for rows and the thread for sporadic modules
};

/// A lifecycle transition of a module.
struct Change {
  std::int64_t time_ns = 0;
  std::uint32_t module = 0;
  std::string from;
  std::string to;
  std::string event;
  std::string text{};  ///< the reason; may be empty
};

/// The kernel's counters at one instant. The node reads them about every 50 ms.
struct Sample {
  std::int64_t time_ns = 0;
  /// For each executor, the counters of its thread for rows and of its sporadic thread.
  std::vector<std::array<std::optional<os::ThreadUse>, 2>> threads{};
  std::vector<Nanoseconds> stolen{};  ///< for each CPU: the time that the hypervisor has taken from it
};

struct Recording {
  std::string cell{};
  std::string device{};
  std::string machine{};
  std::string kernel{};
  Nanoseconds minor_fault{};  ///< duration of a page fault on this machine that does not read from a disk
  std::string why{};          ///< the event or command that caused the recording
  std::int64_t taken_ns = 0;  ///< time of the recording, monotonic
  std::int64_t wall_ns = 0;   ///< the same instant as taken_ns, since 1970
  Nanoseconds last{};         ///< only the last part of the recording, of this duration, is shown
  std::int64_t t0_ns = 0;     ///< T0 of the rows, monotonic; 0 if not yet known
  std::vector<Module> modules{};
  std::vector<Executor> executors{};
  std::vector<Change> changes{};
  std::vector<Sample> samples{};  ///< the oldest sample is first
};

}  // namespace takt::flight
