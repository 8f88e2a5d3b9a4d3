// Starts programs for a measurement: `takt` and its nodes, as users run them, and a background load.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/process.hpp>
#include <takt/os/signals.hpp>

namespace takt::bench {

/// Detects that the user asks this program to end (Ctrl-C) while other programs run for it. Create only one
/// at a time, before any thread is started.
class Interruption {
 public:
  static Result<Interruption> create();
  /// Whether there has been a request, now or earlier.
  [[nodiscard]] bool ended();
  [[nodiscard]] const os::Fd& fd() const noexcept { return signals_.fd(); }

 private:
  explicit Interruption(os::SignalQueue signals) : signals_(std::move(signals)) {}
  os::SignalQueue signals_;
  bool ended_ = false;
};

/// The problem to return after an interruption.
Problem asked_to_end();

/// Starts a program from the folder of this program ("takt", "takt-node"). It uses only the loopback
/// interface, unless TAKT_INTERFACE is set.
Result<os::Child> start_beside(const std::string& program, const std::vector<std::string>& arguments,
                               bool capture_output);

/// Runs such a program to its end and returns its standard output. Fails with its standard error if its
/// status is not 0. An interruption asks the program to end, and is also a failure.
Result<std::string> run_beside(const std::string& program, const std::vector<std::string>& arguments,
                               Interruption& interruption);

/// Runs stress-ng on all CPUs during the lifetime of this object. Fails if stress-ng is not installed, with
/// the package to install.
class Load {
 public:
  static Result<Load> start();
  Load(Load&&) = default;
  Load& operator=(Load&&) = delete;
  ~Load();
  /// The command line, for the report.
  static std::string words();

 private:
  explicit Load(os::Child child) : child_(std::move(child)) {}
  os::Child child_;
};

}  // namespace takt::bench
