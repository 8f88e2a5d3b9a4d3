// What is known of the last seconds of a device: what its executors did, and what happened around them.
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
  Nanoseconds budget{};              ///< of one run(); 0: none
  std::vector<std::string> ports{};  ///< their names by place; empty: not known
};

/// What a thread was at when it was looked at, or when its host died.
struct Open {
  std::uint32_t module = 0;
  channel::Doing doing = channel::Doing::nothing;
  std::int64_t since_ns = 0;
  std::int64_t seen_ns = 0;
  bool host_died = false;
};

/// One thread of an executor: that of its rows or that of its sporadic modules.
struct Thread {
  channel::FlightCopy copy{};
  std::vector<Open> open{};  ///< one for each host that died in it, and what it is at now
};

struct Executor {
  std::string name;
  Nanoseconds basic_period{};
  std::array<Thread, 2> threads{};  ///< of rows, of sporadic modules
};

/// A step of a module through its lifecycle.
struct Change {
  std::int64_t time_ns = 0;
  std::uint32_t module = 0;
  std::string from;
  std::string to;
  std::string event;
  std::string text{};  ///< why; may be empty
};

/// What the kernel counted until then.
struct Sample {
  std::int64_t time_ns = 0;
  std::vector<std::array<std::optional<os::ThreadUse>, 2>> threads{};  ///< of each executor
  std::vector<Nanoseconds> stolen{};                                   ///< of each processor
};

struct Recording {
  std::string cell{};
  std::string device{};
  std::string machine{};
  std::string kernel{};
  std::string why{};          ///< it was taken
  std::int64_t taken_ns = 0;  ///< monotonic
  std::int64_t wall_ns = 0;   ///< at that instant, since 1970
  Nanoseconds last{};         ///< that is to be shown of it
  std::int64_t t0_ns = 0;     ///< T0 of the rows, monotonic; 0: none is agreed
  std::vector<Module> modules{};
  std::vector<Executor> executors{};
  std::vector<Change> changes{};
  std::vector<Sample> samples{};  ///< the oldest first
};

}  // namespace takt::flight
