// What is tested: a thread module or a program, behind one set of hooks.
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

/// The time that tests are at.
class VirtualClock final : public Clock {
 public:
  Instant now() noexcept override { return now_; }
  void go_to(Instant now) noexcept { now_ = now; }

 private:
  // Not 0, which means "never" to what counts from there.
  Instant now_ = from_ns(1'000'000'000'000);
};

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
  /// Its process dies under it.
  virtual void crash() = 0;
  /// It crashed, or is a program that has come to its end; to recover it has to be loaded and started again.
  [[nodiscard]] virtual bool ended() const = 0;
  /// What it saved is gone.
  virtual void forget() {}

  /// Before initialize(): whether it would be taken.
  virtual Result<void> check(const std::string& name, const std::string& text) = 0;
  virtual Result<void> set(const std::string& name, const std::string& text) = 0;
  /// Empty where it has to be looked up among what was set.
  [[nodiscard]] virtual std::optional<Result<std::string>> get(const std::string& name) const = 0;

  [[nodiscard]] virtual const std::vector<PortBase*>& ports() const = 0;
  virtual void connect(PortBase& port, channel::Link link) { port.connect(link, nullptr); }
  /// Of a thread module: as host::ThreadModule.
  virtual void watch(channel::Link, const PortBase&, bool /*stale_is_error*/) {}
  /// Memory that the ports use, as long as they may.
  virtual void keep(std::shared_ptr<void>) {}

  /// What the executor calls or releases.
  virtual void enter(executor::Unit& unit) = 0;
  /// After each row: what was released runs, and what was asked is answered by its handler. An error type
  /// where it went wrong.
  virtual void serve(channel::ModuleBlock& block) = 0;
};

std::unique_ptr<Subject> make_thread_subject(std::string path, bool sporadic, Nanoseconds period,
                                             VirtualClock& clock, const channel::ModuleBlock& block);
std::unique_ptr<Subject> make_program_subject(std::string path, bool sporadic, Nanoseconds period,
                                              VirtualClock& clock);

/// Files whose variables are taken: a further one of these is loaded with variables of its own. While it
/// lives.
class LoadedFile {
 public:
  LoadedFile() = default;
  LoadedFile(const LoadedFile&) = delete;
  LoadedFile& operator=(const LoadedFile&) = delete;
  ~LoadedFile() { release(); }

  static bool is_taken(const std::string& path);
  void take(const std::string& path);
  void release();

 private:
  std::string path_;
};

}  // namespace takt::testing
