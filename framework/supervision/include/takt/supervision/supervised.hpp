// The agent's interface to a deployment on its device: prepare, start, command, observe and stop it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/wire/takt.h>
#include <takt/component.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/lifecycle/machine.hpp>
#include <takt/model/safe.hpp>

namespace takt::supervision {

/// A step of a module through its lifecycle.
struct Step {
  std::uint32_t module = 0;  ///< its index on the device
  lifecycle::Transition transition;
  ErrorType error = ErrorType::none;  ///< the kind of error, for the event `error`
  std::string text{};                 ///< the reason; may be empty
};

/// The present condition of the device.
struct Standing {
  bool real_time = true;
  int host_pid = 0;
  std::uint32_t host_restarts = 0;
  std::uint32_t executing = 0;  ///< number of modules in EXECUTING
  std::string faulty;           ///< the first module in RECOVER or given up, with the reason; empty if there
                                ///< is none
};

/// The statistics of executors, modules and ports. The publisher fills in sequence numbers and times.
struct Measures {
  std::vector<ModuleStatistics> modules;
  std::vector<ExecutorStatistics> executors;
  std::vector<PortStatus> ports;
};

/// The commands of an operator to a module. Each is one or more events of the lifecycle's table.
enum class Verb { initialize, start, stop, recover, reset, destruct };
const char* name_of(Verb verb) noexcept;

/// The outcome of a command.
struct Outcome {
  ReplyCode code = REPLY_OK;
  lifecycle::State state = lifecycle::State::idle;  ///< the module's state after the command
  std::string text;                                 ///< why it failed, or what is still in progress
  std::string value{};                              ///< the value of the requested property
};

/// The topic and type of a port's samples.
struct Tapped {
  std::string topic;
  std::string type;  ///< in the format of model::parse_type()
  bool reliable = false;
  /// Topic and type of the replies of a service; empty for any other port.
  std::string reply_topic{};
  std::string reply_type{};
};

class Supervised {
 public:
  enum class Phase {
    preparing,  ///< modules are being loaded, initialised and started
    ready,      ///< every module is in START; go() is awaited
    running,
    stopping,
    ended,
  };
  virtual ~Supervised() = default;

  /// Starts the hosts and programs, and brings every module to START. Fails if the device cannot be brought
  /// up at all, and leaves nothing running.
  virtual Result<void> prepare() = 0;
  /// Starts the executors when every module is in START: the first row runs at T0. If T0 has passed (a
  /// restored deployment), they begin with the first row of the grid that they can still meet; earlier rows
  /// do not count as missed.
  virtual void go(Instant t0) = 0;
  /// Shuts the device down. Each step has a time limit, after which the step is forced.
  virtual void stop() = 0;
  /// Shuts the device down because of `problem`, which becomes a failure of the device.
  virtual void stop_for(Problem problem) = 0;
  /// Sets the safe values of the cell's outputs, including those of other devices. Must be called before
  /// go().
  virtual void give_safe(const std::vector<model::SafeOutput>& outputs) = 0;
  /// Reacts to what has happened; never waits. Call it whenever a host or program reports something, and
  /// every few milliseconds.
  virtual void step() = 0;

  /// Carries out a command. `done` is called from step(), or at once.
  virtual void command(std::uint32_t module, Verb verb, std::function<void(const Outcome&)> done) = 0;

  /// Publishes the samples of an output on its topic until `until`; opens a service to requests from any
  /// program.
  virtual Result<Tapped> tap(std::uint32_t module, const std::string& port, Instant until) = 0;
  /// Reads a property's value: the present value, or the value that applies from the module's next call on.
  /// `done` is called as for command().
  virtual void get(std::uint32_t module, const std::string& property,
                   std::function<void(const Outcome&)> done) = 0;
  /// Sets a property between two calls of the module; the answer may come before the next call. The value
  /// lasts until the module is loaded again; then the descriptor's value applies.
  virtual void set(std::uint32_t module, const std::string& property, const std::string& value,
                   std::function<void(const Outcome&)> done) = 0;

  /// Fails if this module cannot be swapped now.
  [[nodiscard]] virtual Result<void> may_swap(std::uint32_t module) const = 0;
  /// Replaces the module's instance by a new one from this file, which was inspected before. The module
  /// misses no release and stays in EXECUTING. If the swap or the first runs fail, the old instance
  /// continues. `done` is called as for command().
  virtual void swap(std::uint32_t module, const std::string& path,
                    std::function<void(const Outcome&)> done) = 0;

  /// Makes a trace of the time span `last` until now, as Chrome trace JSON of at most `most` bytes. `done` is
  /// called from step().
  virtual void trace(Nanoseconds last, std::size_t most,
                     std::function<void(const Result<std::string>&)> done) = 0;

  [[nodiscard]] virtual Phase phase() const noexcept = 0;
  /// Why the device failed as a whole, and which modules were given up; empty if there were no failures.
  [[nodiscard]] virtual const Problems& failures() const noexcept = 0;
  /// True if the device failed because of a module whose failure stops the whole cell.
  [[nodiscard]] virtual bool stops_cell() const noexcept = 0;
  [[nodiscard]] virtual Standing standing() const = 0;
  /// The device's object in the JSON of `takt status --json`.
  [[nodiscard]] virtual nlohmann::ordered_json report() const = 0;
  [[nodiscard]] virtual Measures measures() const = 0;

 protected:
  Supervised() = default;
  Supervised(const Supervised&) = default;
  Supervised& operator=(const Supervised&) = default;
};

}  // namespace takt::supervision
