// The interface to the tested module, which is the same for thread modules and process modules.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/module.h>
#include <takt/channel/layout.hpp>
#include <takt/channel/link.hpp>
#include <takt/component.hpp>
#include <takt/core/clock.hpp>
#include <takt/core/result.hpp>
#include <takt/executor/executor.hpp>

namespace takt::testing {

/// The virtual time of a test.
class VirtualClock final : public Clock {
 public:
  Instant now() noexcept override { return now_; }
  void go_to(Instant now) noexcept { now_ = now; }

 private:
  // The first time is not 0, because other code uses 0 for "never".
  Instant now_ = from_ns(1'000'000'000'000);
};

/// The tested module.
class Subject {
 public:
  Subject() = default;
  Subject(const Subject&) = delete;
  Subject& operator=(const Subject&) = delete;
  virtual ~Subject() = default;

  virtual Result<void> load() = 0;
  virtual Result<void> initialize(const irp::Property& properties) = 0;
  virtual Result<void> start() = 0;
  virtual Result<void> error(ErrorType type) = 0;
  virtual Result<void> recover() = 0;
  virtual Result<void> destruct() = 0;
  /// Simulates that the module's process dies.
  virtual void crash() = 0;
  /// True if the module has crashed, or if it is a process module whose program has ended. To recover, such a
  /// module must be loaded and started again.
  [[nodiscard]] virtual bool ended() const = 0;
  /// The ring with the log lines of the module. A process module gets a new ring, with the same level, with
  /// each load().
  virtual channel::LogRing& log_ring() = 0;
  /// Discards the module's saved state.
  virtual void forget() {}

  /// Checks, before initialize(), that the module accepts this value of the property. A C++ module also takes
  /// the value.
  virtual Result<void> check(const std::string& name, const std::string& text) = 0;
  virtual Result<void> set(const std::string& name, const std::string& text) = 0;
  /// The value of a property. Empty if the module does not know its value; the caller then uses the value
  /// that the test set.
  [[nodiscard]] virtual std::optional<Result<std::string>> get(const std::string& name) const = 0;

  [[nodiscard]] virtual const std::vector<PortBase*>& ports() const = 0;
  virtual void connect(PortBase& port, channel::Link link) { port.connect(link, nullptr); }
  /// Checks the deadline of an input, in the same way as host::ThreadModule::check_deadline(). Thread modules
  /// only.
  virtual void check_deadline(channel::Link, const PortBase&, bool /*stale_is_error*/) {}
  /// Keeps this memory, which the ports use, alive as long as the ports.
  virtual void keep(std::shared_ptr<void>) {}

  /// Sets the fields of `unit` through which the executor calls or releases the module.
  virtual void enter(executor::Unit& unit) = 0;
  /// Called after each row. Lets a released program run its body, and lets handlers answer requests. Records
  /// in `block` if the program failed or has finished.
  virtual void serve(channel::ModuleBlock& block) = 0;
};

std::unique_ptr<Subject> make_thread_subject(std::string path, bool sporadic, Nanoseconds period,
                                             VirtualClock& clock, channel::ModuleBlock& block);
std::unique_ptr<Subject> make_program_subject(std::string path, bool sporadic, Nanoseconds period,
                                              VirtualClock& clock);

/// Marks a file as loaded while this object lives. A second module of the same file is loaded as a copy, with
/// its own variables.
class LoadedFile {
 public:
  LoadedFile() = default;
  LoadedFile(const LoadedFile&) = delete;
  LoadedFile& operator=(const LoadedFile&) = delete;
  ~LoadedFile() { release(); }

  /// True if another LoadedFile has marked the file.
  static bool is_taken(const std::string& path);
  void take(const std::string& path);
  void release();

 private:
  std::string path_;
};

}  // namespace takt::testing
