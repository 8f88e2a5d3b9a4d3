// A snapshot of a DDS domain, as plain data for the screen of `takt watch`. It combines the reports of the
// nodes with the descriptor of the running cell.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

#include "reports/graph_report.hpp"

namespace takt::tool::watch {

struct Quantiles {
  double mean = 0;
  double p50 = 0;
  double p99 = 0;
  double p999 = 0;
  double max = 0;
};

struct Measured {
  std::uint64_t cycles = 0;
  std::uint64_t missed = 0;
  std::uint64_t overruns = 0;
  std::uint64_t over_budget = 0;
  std::uint64_t errors = 0;
  std::uint64_t recoveries = 0;
  Quantiles jitter_us{};
  Quantiles run_us{};
};

/// What the descriptor says about a module.
struct Planned {
  std::string words;  ///< "thread, periodic, every 1 ms"
  std::string executor{};
  int priority = 0;
  std::optional<Nanoseconds> period{};
  std::optional<Nanoseconds> budget{};
};

struct Port {
  std::string name;
  bool output = false;
  std::string type{};
  bool connected = false;
  std::uint64_t samples = 0;
  CellHealth::Connection health{};
};

struct Transition {
  std::int64_t time_ns = 0;
  std::string text;  ///< "EXECUTING -> RECOVER (why)"
};

struct Module {
  std::string name;
  std::string state;   ///< "EXECUTING"
  std::string text{};  ///< the reason for the state, or empty
  std::optional<Measured> measured{};
  std::optional<Planned> planned{};
  std::vector<double>
      minute_us{};  ///< rms jitter per second, of the last minute, newest last; NaN: did not run
  std::vector<Port> ports{};
  std::vector<Transition> transitions{};  ///< oldest first

  /// A run of length `run_us`, as a share of the module's budget. None if the module has no budget or no
  /// measurements.
  [[nodiscard]] std::optional<double> share(double run_us) const;
};

struct Executor {
  std::string name;
  std::uint64_t cycles = 0;
  std::uint64_t missed = 0;
  std::uint64_t late = 0;
  double margin_us = 0;
  Quantiles jitter_us{};
};

struct Device {
  std::string name;
  std::string cell;    ///< empty if the device has no deployment
  std::string state;   ///< "running"
  std::string health;  ///< "ok"
  std::string text{};  ///< the reason for the health, if it is not "ok"
  bool alive = true;   ///< false if the node is lost; the other values are then the last known ones
  bool real_time = true;
  std::string machine{};
  std::int32_t process_id = 0;
  std::int32_t host_process_id = 0;
  std::uint32_t host_restarts = 0;
  std::vector<Executor> executors{};
  std::vector<Module> modules{};
};

struct Connection {
  std::string from;
  std::string to;
  std::string kind;
  std::optional<CellHealth::Connection> health{};  ///< none if no node has reported it
};

struct Snapshot {
  int domain = 0;
  std::string clock{};  ///< "12:34:56"
  std::vector<Device> devices{};
  std::vector<Connection> connections{};
  bool connections_known = false;       ///< whether a node has reported the connections
  std::vector<std::string> events{};    ///< the newest events, oldest first
  std::vector<std::string> commands{};  ///< unanswered commands, with their age: "stop of robot.servo, 3 s"

  /// The device of `target`, which is "DEVICE" or "DEVICE.MODULE". Null if the device no longer exists.
  [[nodiscard]] const Device* device(const std::string& target) const;
  [[nodiscard]] const Module* module(const std::string& target) const;
};

/// A wall-clock time as local time: "12:34:56.789".
std::string clock_text(std::int64_t wall_ns);

}  // namespace takt::tool::watch
