// The agent's interface to a deployment on its device: prepare, start, command, observe and stop it.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
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
  std::uint32_t module = 0;  ///< index of the module on the device
  lifecycle::Transition transition;
  ErrorType error = ErrorType::none;  ///< the kind of error, if the event is `error`
  std::string text{};                 ///< the reason; may be empty
};

/// The present condition of the device.
struct Standing {
  bool real_time = true;
  int host_pid = 0;
  std::uint32_t host_restarts = 0;
  std::uint32_t executing = 0;  ///< number of modules in EXECUTING
  std::string faulty;           ///< the first module that is in RECOVER or was given up, with the reason;
                                ///< empty if there is none
};

/// The statistics of executors, modules and ports. The publisher fills in sequence numbers and times.
struct Measures {
  std::vector<ModuleStatistics> modules;
  std::vector<ExecutorStatistics> executors;
  std::vector<PortStatus> ports;
};

/// The commands of an operator to a module. Each command causes one or more events of the lifecycle's table.
enum class Verb { initialize, start, stop, recover, reset, destruct };
const char* name_of(Verb verb) noexcept;

/// The outcome of a command.
struct Outcome {
  ReplyCode code = REPLY_OK;
  lifecycle::State state = lifecycle::State::idle;  ///< the module's state after the command
  std::string text;                                 ///< the reason why the command failed, or a text about
                                                    ///< actions that are still in progress
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

/// A request to force an input: its module then reads the given value instead of the samples of the connected
/// output.
struct ForceRequest {
  std::string port;
  std::string data;    ///< the value as a JSON object, or as a JSON array of texts FIELD=VALUE; empty: renews
  std::string client;  ///< identifies the client, which alone can renew the force
  std::string by{};    ///< who forces the input, for people
  Nanoseconds duration{};  ///< the longest duration of the force
};

class Supervised {
 public:
  enum class Phase {
    preparing,  ///< modules are being loaded, initialised and started
    ready,      ///< every module is in START; the device waits for go()
    running,
    stopping,
    ended,
  };
  virtual ~Supervised() = default;

  /// Starts the hosts and programs. Then step() brings every module to START. If the device cannot start at
  /// all, prepare() fails and leaves nothing running.
  virtual Result<void> prepare() = 0;
  /// Starts the executors of a device in phase `ready`: the first row runs at `t0`. If `t0` has passed, as in
  /// a restored deployment, the executors begin with the next row of the grid that they can begin on time.
  /// Earlier rows do not count as missed.
  virtual void go(Instant t0) = 0;
  /// Shuts the device down. Each step has a time limit, after which the step is forced.
  virtual void stop() = 0;
  /// Shuts the device down because of `problem`, which becomes a failure of the device.
  virtual void stop_for(Problem problem) = 0;
  /// Sets the safe values of the cell's outputs, including those of other devices. Must be called before
  /// go().
  virtual void give_safe(const std::vector<model::SafeOutput>& outputs) = 0;
  /// Reacts to all events since the last call; never waits. Call this whenever a host or program reports
  /// something, and every few milliseconds.
  virtual void step() = 0;

  /// Carries out an operator's command to a module. `done` receives the outcome, either from step() or from
  /// this call.
  virtual void command(std::uint32_t module, Verb verb, std::function<void(const Outcome&)> done) = 0;

  /// Opens a port to the outside until `until`: publishes the samples of an output on its topic, or lets any
  /// program call a service. `every`: publish only the newest sample, once in this time; 0: every sample.
  virtual Result<Tapped> tap(std::uint32_t module, const std::string& port, Instant until,
                             Nanoseconds every) = 0;
  /// Forces an input that holds the latest value, or renews the force. Returns the value with all its fields,
  /// as JSON; after a renewal, an empty text. The force ends after its duration, 2 s after the last renewal,
  /// when end_force() is called, and when the module is stopped, reset or swapped, or leaves EXECUTING.
  virtual Result<std::string> force(std::uint32_t module, const ForceRequest& request) = 0;
  /// Ends the force of an input. `who` asked for it.
  virtual Result<void> end_force(std::uint32_t module, const std::string& port, const std::string& who) = 0;
  /// Reads a property's value: the present value, or the value that applies when the module is called next.
  /// `done` receives the value, either from step() or from this call.
  virtual void get(std::uint32_t module, const std::string& property,
                   std::function<void(const Outcome&)> done) = 0;
  /// Sets a property between two calls of the module. The answer may come before the next call. The module
  /// keeps the value, even when it is loaded again, until an update of the cell changes the value.
  virtual void set(std::uint32_t module, const std::string& property, const std::string& value,
                   std::function<void(const Outcome&)> done) = 0;

  /// Checks whether the module can be swapped now. Fails with the reason if it cannot.
  [[nodiscard]] virtual Result<void> may_swap(std::uint32_t module) const = 0;
  /// Replaces the module's instance by a new instance from the component at `path`, which the caller has
  /// inspected. The new instance has the present values of the module's properties, except those in `values`,
  /// by name. The module misses no release and stays in EXECUTING. If the swap or one of the new instance's
  /// first runs fails, the old instance continues with its own values. `done` receives the outcome, either
  /// from step() or from this call.
  virtual void swap(std::uint32_t module, const std::string& path,
                    const std::map<std::string, std::string>& values,
                    std::function<void(const Outcome&)> done) = 0;

  /// Makes a trace of the last `last` ns, as Chrome trace JSON of at most `most` bytes. step() calls `done`
  /// with the trace.
  virtual void trace(Nanoseconds last, std::size_t most,
                     std::function<void(const Result<std::string>&)> done) = 0;

  /// Returns a connection to another device whose other end has not been found yet, such as
  /// "robot.arm.measured -> station.panel.arm". Empty if there is none.
  [[nodiscard]] virtual std::string unmatched() const = 0;
  [[nodiscard]] virtual Phase phase() const noexcept = 0;
  /// The reasons why the device failed as a whole, and the modules that were given up; empty if nothing
  /// failed.
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
