// The interfaces that the supervision acts on: a clock, hosts, programs and flows. The node implements them
// with real processes and DDS, the simulation with virtual ones. No function waits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/host/protocol.hpp>
#include <takt/model/hosts.hpp>
#include <takt/supervision/supervised.hpp>
#include <takt/wire/flow_health.hpp>

namespace takt::supervision {

struct Parts;

/// How a host or a program ended.
struct ProcessEnd {
  std::string text;  ///< "ended with status 3", "was killed by SIGSEGV (Segmentation fault)"
  bool signalled = false;
  int code = 0;           ///< the signal, or the exit status
  std::string core{};     ///< the file of its core dump; empty if there is none
  std::string no_core{};  ///< why there is no core dump, if a signal ended the process
};

/// Where a host crashed; both are empty if it left no crash report.
struct CrashCalls {
  std::string place;    ///< ", in F at file.cpp:1 in module.so"
  std::string callers;  ///< ", called by ..."; used only in the fault record
};

/// A process that loads thread modules and runs executors. It can be started again after it has ended.
class Host {
 public:
  virtual ~Host() = default;
  virtual Result<void> start() = 0;
  /// Sends a request. Returns false if the host has ended.
  virtual bool ask(const host::Request& request) = 0;
  /// Returns the next answer that has arrived, or nothing.
  virtual std::optional<host::Answer> answer() = 0;
  /// Returns how the host ended, once for each end. Returns nothing while the host has not ended.
  virtual std::optional<ProcessEnd> ended() = 0;
  virtual void kill() = 0;
  [[nodiscard]] virtual bool running() const = 0;
  /// The PID of the last process; 0 if there was none.
  [[nodiscard]] virtual int pid() const = 0;
  /// Returns the calls that led to the crash of a module. Must be called before the crash report is cleared.
  virtual CrashCalls calls_of_crash(std::uint32_t module) = 0;
};

/// A program: a process module, or a non-real-time program. It can be started again after it has ended.
class Program {
 public:
  virtual ~Program() = default;
  virtual Result<void> start() = 0;
  /// Returns how the program ended, once for each end. Returns nothing while the program has not ended.
  virtual std::optional<ProcessEnd> ended() = 0;
  /// Asks the program to end, as SIGTERM does.
  virtual void terminate() = 0;
  virtual void kill() = 0;
  /// Makes the thread that waits for releases real-time.
  virtual Result<void> make_real_time() = 0;
  [[nodiscard]] virtual bool running() const = 0;
  /// The PID of the last process; 0 if there was none.
  [[nodiscard]] virtual int pid() const = 0;
  /// The last line that the program printed; empty if it printed nothing.
  [[nodiscard]] virtual std::string last_line() const = 0;
};

/// Moves the samples that this device exchanges with other devices and with observers.
class Flows {
 public:
  virtual ~Flows() = default;
  /// Returns nothing while the flows are being opened, then whether all of them could be opened.
  [[nodiscard]] virtual std::optional<Result<void>> opened() const = 0;
  virtual void step(Instant now) = 0;
  /// The health of the flow that a wire belongs to; none if the wire has no flow or the flow is not open.
  [[nodiscard]] virtual std::optional<wire::FlowHealth> health(std::size_t wire) const = 0;
  /// Opens the flow of an output without connections until `until`, so that observers can read the output.
  /// Another call extends the time.
  virtual Result<void> tap(std::uint32_t module, const std::string& port, Instant until) = 0;
  /// Opens the flows through which any program may call a service of the module, until `until`. Another call
  /// extends the time.
  virtual Result<void> open_service(std::uint32_t module, const std::string& service, Instant until) = 0;
};

/// Something that the platform has detected and that the operator must know.
struct Detection {
  std::optional<std::uint32_t> module;  ///< none if it concerns the device
  std::string text;                     ///< for the log
  std::string cause{};                  ///< for a `not_real_time` entry in the fault record; empty for none
};

class Platform {
 public:
  virtual ~Platform() = default;

  [[nodiscard]] virtual Instant now() const = 0;
  /// Prepares the machine: chooses CPUs (parts.placement), decides whether the device is real-time
  /// (parts.real_time), and loads the state that modules retain. Called once, before anything is started;
  /// `parts` outlives the platform.
  virtual Result<void> begin(Parts& parts) = 0;
  /// The longest time that a program may spin before each release of a module with this period.
  [[nodiscard]] virtual Nanoseconds spin_limit(const model::Module& module, Nanoseconds period) const = 0;
  virtual std::unique_ptr<Host> make_host(std::size_t share) = 0;
  virtual std::unique_ptr<Program> make_program(std::uint32_t module) = 0;
  /// The result is null if the device exchanges no samples with other devices.
  virtual Result<std::unique_ptr<Flows>> open_flows() = 0;
  /// Wakes the threads that sleep on these bits of the wake word.
  virtual void wake(std::uint32_t bits) = 0;
  /// Passes on what programs printed. Called at the beginning of each step of the supervision.
  virtual void step(Instant now) = 0;
  /// Returns what was detected since the last call.
  virtual std::vector<Detection> detections() = 0;
  /// Writes the last files, without waiting. Returns true once they are written.
  virtual bool finish() = 0;
  /// Failures of the device that are certain only when all its processes have ended.
  virtual Problems final_problems() = 0;
  /// Adds what only this platform knows to the device's status JSON.
  virtual void add_to(nlohmann::ordered_json& report) const = 0;

  /// Writes a line to the log; `module` is empty for the device.
  virtual void log(const std::string& module, const std::string& text) = 0;
  /// Called when a module has taken a step through its lifecycle.
  virtual void stepped(const Step& step) = 0;
  /// Called when a module was put into the tables or taken out of them.
  virtual void in_tables(std::uint32_t module, bool in) = 0;
  virtual void recovering(std::uint32_t module, int attempt) = 0;
  /// Called for a fault, so that the platform writes a trace of it.
  virtual void fault(const std::string& why) = 0;
  /// Called before the blocks of a host that has ended are cleared.
  virtual void host_died(const model::HostShare& share) = 0;
  /// Makes a trace of the time span `last` until now, as Chrome trace JSON of at most `most` bytes. `done` is
  /// called from step().
  virtual void trace(Nanoseconds last, std::size_t most,
                     std::function<void(const Result<std::string>&)> done) = 0;
};

}  // namespace takt::supervision
