// A snapshot of a DDS domain, as plain data for the screen of `takt watch`. The snapshot combines the reports
// of the nodes with the descriptor of the running cell.
#pragma once

#include <cstdint>
#include <map>
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
  std::string words;  ///< for example "thread, periodic, every 1 ms"
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
  std::string source{};  ///< the output that writes its samples, "device.module.port"; empty if none is known
};

struct Transition {
  std::int64_t time_ns = 0;
  std::string text;  ///< for example "EXECUTING -> RECOVER (why)"
};

struct Module {
  std::string name;
  std::string state;       ///< for example "EXECUTING"
  std::string text{};      ///< the reason for the state, or empty
  bool stopped = false;    ///< an operator stopped the module, so it is in START although its device runs
  bool given_up = false;   ///< the node gave the module up after an error
  bool safe_stop = false;  ///< the module reports that it is in a safe stop
  bool forced = false;     ///< an operator forces an input of the module
  std::optional<Measured> measured{};
  std::optional<Planned> planned{};
  std::string component{};  ///< file, version and hash: "servo.so 1.2.0 3fa91c02"; empty if not known
  std::vector<double>
      minute_us{};  ///< rms jitter in each of the last 60 seconds, newest last; NaN: not known
  std::vector<Port> ports{};
  std::vector<Transition> transitions{};  ///< oldest first

  /// Returns `run_us` as a share of the module's budget. None if the module has no budget or no measurements.
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
  std::string state;   ///< for example "running"
  std::string health;  ///< for example "ok"
  std::string text{};  ///< the reason for the health, if it is not "ok"
  bool alive = true;   ///< false if the node is lost; the other values are then the last known ones
  bool real_time = true;
  std::string machine{};
  std::int32_t process_id = 0;
  std::int32_t host_process_id = 0;
  std::uint32_t host_restarts = 0;
  std::uint32_t alarms = 0;  ///< the number of unacknowledged alarms
  std::vector<Executor> executors{};
  std::vector<Module> modules{};
};

struct Connection {
  std::string from;
  std::string to;
  std::string kind;
  std::optional<CellHealth::Connection> health{};  ///< none if no node has reported it
};

/// An error or a warning in the fault record of a device.
struct Fault {
  std::int64_t time_ns = 0;
  std::string text;
  bool error = false;
};

struct Snapshot {
  int domain = 0;
  std::string clock{};     ///< local time, for example "12:34:56"
  bool searching = false;  ///< `takt watch` began so recently that it may not have found the devices yet
  std::vector<Device> devices{};
  std::vector<Connection> connections{};
  bool connections_known = false;     ///< true: at least one node has reported its connections
  std::vector<std::string> events{};  ///< the newest transitions and losses, oldest first
  std::vector<Fault> faults{};        ///< the newest errors and warnings of the fault records, oldest first
  /// The newest samples of the outputs that the details need, by "device.module.port".
  std::map<std::string, std::string> values{};
  std::vector<std::string> commands{};  ///< unanswered commands, with their age: "stop of robot.servo, 3 s"

  /// The device of `target`, which is "DEVICE" or "DEVICE.MODULE". Null if the device no longer exists.
  [[nodiscard]] const Device* device(const std::string& target) const;
  [[nodiscard]] const Module* module(const std::string& target) const;
};

/// A wall-clock time as local time: "12:34:56.789".
std::string clock_text(std::int64_t wall_ns);

}  // namespace takt::tool::watch
