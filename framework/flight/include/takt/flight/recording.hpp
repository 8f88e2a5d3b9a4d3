// A recording of the last few seconds of a device: what its executors did, and what happened around them.
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
  Nanoseconds budget{};              ///< budget of one run(); 0 for none
  std::vector<std::string> ports{};  ///< names of the ports, in order; empty if unknown
};

/// What a thread was doing when the recording was made, or when its host died.
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
  std::vector<Open> open{};  ///< one for each host that died in this thread, and one for the present activity
};

struct Executor {
  std::string name;
  Nanoseconds basic_period{};
  std::array<Thread, 2> threads{};  ///< the thread for rows and the thread for sporadic modules
};

/// A lifecycle step of a module.
struct Change {
  std::int64_t time_ns = 0;
  std::uint32_t module = 0;
  std::string from;
  std::string to;
  std::string event;
  std::string text{};  ///< the reason; may be empty
};

/// The kernel's counters at one instant.
struct Sample {
  std::int64_t time_ns = 0;
  /// The counters of the two threads of each executor.
  std::vector<std::array<std::optional<os::ThreadUse>, 2>> threads{};
  std::vector<Nanoseconds> stolen{};  ///< the time stolen from each CPU
};

struct Recording {
  std::string cell{};
  std::string device{};
  std::string machine{};
  std::string kernel{};
  std::string why{};          ///< the reason for the recording
  std::int64_t taken_ns = 0;  ///< time of the recording, monotonic
  std::int64_t wall_ns = 0;   ///< the same instant since 1970
  Nanoseconds last{};         ///< how much of the recording to show
  std::int64_t t0_ns = 0;     ///< T0 of the rows, monotonic; 0 if not yet known
  std::vector<Module> modules{};
  std::vector<Executor> executors{};
  std::vector<Change> changes{};
  std::vector<Sample> samples{};  ///< samples, the oldest first
};

}  // namespace takt::flight
