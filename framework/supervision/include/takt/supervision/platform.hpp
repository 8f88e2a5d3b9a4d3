// The interfaces that the supervision uses: a clock, hosts, programs and flows. The node implements them with
// real processes and DDS, and the simulation with virtual ones. No function of these interfaces blocks.
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
  int code = 0;           ///< number of the signal if `signalled` is true, otherwise the exit status
  std::string core{};     ///< path of the core dump; empty if there is none
  std::string no_core{};  ///< the reason why there is no core dump, if a signal ended the process
};

/// Where a host crashed or hung. Both texts are empty if the host left no crash report.
struct CrashCalls {
  std::string place;    ///< ", in F at file.cpp:1 in module.so"
  std::string callers;  ///< ", called by ..."; used only in the fault record
};

/// A process that loads thread modules and runs executors. start() can be called again after the process has
/// ended.
class Host {
 public:
  virtual ~Host() = default;
  virtual Result<void> start() = 0;
  /// Sends a request. Returns false if the host has ended.
  virtual bool ask(const host::Request& request) = 0;
  /// Returns the next answer that has arrived, or nothing.
  virtual std::optional<host::Answer> answer() = 0;
  /// Returns how the host ended, once for each end of the host. Otherwise the result is empty.
  virtual std::optional<ProcessEnd> ended() = 0;
  virtual void kill() = 0;
  /// Makes a thread of the host report its calls as in a crash, and then end the host. Has no effect if the
  /// thread does not react.
  virtual void end_by(std::int32_t thread) = 0;
  [[nodiscard]] virtual bool running() const = 0;
  /// The PID of the last process; 0 if there was none.
  [[nodiscard]] virtual int pid() const = 0;
  /// Returns the calls that led to the crash or hang of a module. Must be called before the crash report is
  /// cleared.
  virtual CrashCalls calls_of_crash(std::uint32_t module) = 0;
};

/// The program of a process module, real-time or not. start() can be called again after the program has
/// ended.
class Program {
 public:
  virtual ~Program() = default;
  virtual Result<void> start() = 0;
  /// Returns how the program ended, once for each end of the program. Otherwise the result is empty.
  virtual std::optional<ProcessEnd> ended() = 0;
  /// Asks the program to end, as SIGTERM does.
  virtual void terminate() = 0;
  virtual void kill() = 0;
  /// Gives a real-time priority to the program's thread that waits for releases.
  virtual Result<void> make_real_time() = 0;
  /// Wakes the program's thread that answers the request in the program's release slot (see PropertyRequest).
  virtual void wake_for_property() = 0;
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
  /// The result of opening the flows. Empty while they are being opened; a failure if a flow could not be
  /// opened.
  [[nodiscard]] virtual std::optional<Result<void>> opened() const = 0;
  virtual void step(Instant now) = 0;
  /// The health of the flow to which a link belongs; empty if the link has no flow or the flow is not open.
  [[nodiscard]] virtual std::optional<wire::FlowHealth> health(std::size_t link) const = 0;
  /// Begins to open the flow of an output without connections, so that observers can read the output. The
  /// flow closes at `until`; a further call of tap() extends the time. The flow carries every sample while an
  /// observer wants them (`every` is 0), and otherwise only the newest sample once in `every`.
  virtual Result<void> tap(std::uint32_t module, const std::string& port, Instant until,
                           Nanoseconds every) = 0;
  /// Begins to open the flows through which any program may call a service of the module. They close at
  /// `until`; a further call of open_service() extends the time.
  virtual Result<void> open_service(std::uint32_t module, const std::string& service, Instant until) = 0;
};

/// Something that the platform has detected and that the operator must know.
struct Detection {
  std::optional<std::uint32_t> module;  ///< empty if the detection concerns the whole device
  std::string text;                     ///< text for the log
  std::string cause{};                  ///< cause of a `not_real_time` entry in the fault record; empty if
                                        ///< there is no such entry
};

class Platform {
 public:
  virtual ~Platform() = default;

  [[nodiscard]] virtual Instant now() const = 0;
  /// Prepares the machine: chooses CPUs (parts.placement), decides whether the device is real-time
  /// (parts.real_time), and loads the state that modules retain. Called once, before anything is started;
  /// `parts` outlives the platform.
  virtual Result<void> begin(Parts& parts) = 0;
  /// The longest time for which `module`, a process module with this period, may spin before each of its
  /// releases.
  [[nodiscard]] virtual Nanoseconds spin_limit(const model::Module& module, Nanoseconds period) const = 0;
  virtual std::unique_ptr<Host> make_host(std::size_t share) = 0;
  virtual std::unique_ptr<Program> make_program(std::uint32_t module) = 0;
  /// Begins to open the device's flows. The result is null if the device exchanges no samples with other
  /// devices.
  virtual Result<std::unique_ptr<Flows>> open_flows() = 0;
  /// Wakes the threads that sleep on these bits of the wake word.
  virtual void wake(std::uint32_t bits) = 0;
  /// Returns the CPU time of a host's thread if the thread is running, or is ready but has no CPU. Returns
  /// nothing if the thread sleeps or is stopped, or if there is no such thread.
  [[nodiscard]] virtual std::optional<Nanoseconds> ran_if_ready(std::int32_t thread) const = 0;
  /// Does the platform's regular work, such as logging the lines that programs printed. The supervision calls
  /// this function at the beginning of each of its steps.
  virtual void step(Instant now) = 0;
  /// Returns the platform's detections since the last call of detections().
  virtual std::vector<Detection> detections() = 0;
  /// Begins to delete the module's retained state from the disk. Call this after clearing the state in
  /// memory.
  virtual void forget(std::uint32_t module) = 0;
  /// The result of forget(). Empty while the deletion is in progress; success if the disk holds no state of
  /// the module.
  [[nodiscard]] virtual std::optional<Result<void>> forgotten(std::uint32_t module) = 0;
  /// Writes the device's last files (traces and retained state) in the background. Call this repeatedly until
  /// it returns true; then the files are written.
  virtual bool finish() = 0;
  /// Returns the failures of the device that are known only after all its processes have ended.
  virtual Problems final_problems() = 0;
  /// Adds the values that only this platform knows to the device's status JSON.
  virtual void add_to(nlohmann::ordered_json& report) const = 0;

  /// Writes a line to the log; `module` is empty for the device.
  virtual void log(const std::string& module, const std::string& text) = 0;
  /// Called when a module has taken a step through its lifecycle.
  virtual void stepped(const Step& step) = 0;
  /// Called when a module was put into the tables or taken out of them.
  virtual void in_tables(std::uint32_t module, bool in) = 0;
  /// Called when a recovery of a module begins. `attempt` is 0 if it does not count as an attempt.
  virtual void recovering(std::uint32_t module, int attempt) = 0;
  /// Called when a fault occurs, so that the platform writes a trace. `why` is the reason.
  virtual void fault(const std::string& why) = 0;
  /// Called after a host has ended, before its blocks in shared memory are cleared.
  virtual void host_died(const model::HostShare& share) = 0;
  /// Makes a trace of the last `last` ns, as Chrome trace JSON of at most `most` bytes. step() calls `done`
  /// with the trace.
  virtual void trace(Nanoseconds last, std::size_t most,
                     std::function<void(const Result<std::string>&)> done) = 0;
};

}  // namespace takt::supervision
