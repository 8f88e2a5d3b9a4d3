// A deployment on this device as its agent sees it: brought up, let go, looked at, told what to do, ended.
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
#include <takt/os/fd.hpp>

namespace takt::node {

/// A module took a step through its lifecycle.
struct Step {
  std::uint32_t module = 0;  ///< its index on the device
  lifecycle::Transition transition;
  ErrorType error = ErrorType::none;  ///< of the event `error`
  std::string text{};                 ///< why; may be empty
};

/// How the device stands at present.
struct Standing {
  bool real_time = true;
  int host_pid = 0;
  std::uint32_t host_restarts = 0;
  std::uint32_t executing = 0;  ///< modules
  std::string astray;  ///< the first module that is not in the state it should be in, and why; empty: none
};

/// What executors and modules published. Sequence numbers and times are the teller's.
struct Measures {
  std::vector<ModuleStatistics> modules;
  std::vector<ExecutorStatistics> executors;
  std::vector<PortStatus> ports;
};

/// What an operator may ask of a module, each an event of the lifecycle's table.
enum class Verb { initialize, start, stop, recover, reset, destruct };
const char* name_of(Verb verb) noexcept;

/// What became of it.
struct Outcome {
  ReplyCode code = REPLY_OK;
  lifecycle::State state = lifecycle::State::idle;  ///< of the module, after it
  std::string text;                                 ///< why not, or what is still to come
  std::string value{};                              ///< of a property that was asked for
};

/// Where the samples of a port can be read, and what they are.
struct Tapped {
  std::string topic;
  std::string type;  ///< as model::parse_type() reads it
  bool reliable = false;
  /// Of a service: where its replies are, and what; of anything else empty.
  std::string reply_topic{};
  std::string reply_type{};
};

class Supervised {
 public:
  enum class Phase {
    preparing,  ///< modules are loaded, initialised, started
    ready,      ///< every module is in START; go() is awaited
    running,
    stopping,
    ended,
  };
  virtual ~Supervised() = default;

  /// Starts everything. Fails when the device cannot be brought up at all; nothing is left then.
  virtual Result<void> prepare() = 0;
  /// Every module is in START: the first row runs at T0. With a T0 that has passed (a deployment that is
  /// taken up again) it is the first row of that grid which can be met; those before are not missed.
  virtual void go(Instant t0) = 0;
  /// Ends everything in order; each step has a time limit and a kill after it.
  virtual void stop() = 0;
  /// The same, because of this, which is a failure of the device.
  virtual void stop_for(Problem problem) = 0;
  /// The safe values of the cell's outputs, also of other devices', before go().
  virtual void give_safe(const std::vector<model::SafeOutput>& outputs) = 0;
  /// Looks at what has happened, and never waits. To be called whenever one of wait_on() can be read, and
  /// every few milliseconds.
  virtual void step() = 0;
  [[nodiscard]] virtual std::vector<const os::Fd*> wait_on() = 0;

  /// `done` is called from step(), or at once.
  virtual void order(std::uint32_t module, Verb verb, std::function<void(const Outcome&)> done) = 0;

  /// The samples of an output are on its topic until then; or a service takes requests from anybody.
  virtual Result<Tapped> tap(std::uint32_t module, const std::string& port, Instant until) = 0;
  /// The value of a property, as the module has it now or from its next call on. `done` as for order().
  virtual void get(std::uint32_t module, const std::string& property,
                   std::function<void(const Outcome&)> done) = 0;
  /// Sets a property between two calls of the module; the answer may come before the next one. Lasts until
  /// the module is loaded afresh: then it has what the descriptor says.
  virtual void set(std::uint32_t module, const std::string& property, const std::string& value,
                   std::function<void(const Outcome&)> done) = 0;

  /// Fails where no other instance may take the place of this module now.
  [[nodiscard]] virtual Result<void> may_swap(std::uint32_t module) const = 0;
  /// An instance of this file, which was looked at, takes its place without a missed release. The module is
  /// EXECUTING all the time; where that cannot be done, or the first runs go wrong, nothing has changed.
  /// `done` as for order().
  virtual void swap(std::uint32_t module, const std::string& path,
                    std::function<void(const Outcome&)> done) = 0;

  /// What its executors did in the last so many nanoseconds, as Chrome trace JSON of at most `most` bytes.
  /// `done` is called from step().
  virtual void trace(Nanoseconds last, std::size_t most,
                     std::function<void(const Result<std::string>&)> done) = 0;

  [[nodiscard]] virtual Phase phase() const noexcept = 0;
  /// Why the device failed as a whole, or which modules were given up; empty when all is well.
  [[nodiscard]] virtual const Problems& failures() const noexcept = 0;
  /// It failed by a module whose fault is the whole cell's.
  [[nodiscard]] virtual bool stops_cell() const noexcept = 0;
  [[nodiscard]] virtual Standing standing() const = 0;
  /// The device's object of the contract's status JSON.
  [[nodiscard]] virtual nlohmann::ordered_json report() const = 0;
  [[nodiscard]] virtual Measures measures() const = 0;

 protected:
  Supervised() = default;
  Supervised(const Supervised&) = default;
  Supervised& operator=(const Supervised&) = default;
};

}  // namespace takt::node
