// Starts the programs of a measurement: `takt` and its nodes, as users run them, and a background load.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/process.hpp>
#include <takt/os/signals.hpp>

namespace takt::bench {

/// Detects that the user asks `takt bench` to end (Ctrl-C, SIGTERM) while it runs other programs. Create the
/// object before the process starts threads. Only one object may exist at a time.
class Interruption {
 public:
  static Result<Interruption> create();
  /// True if the user has asked `takt bench` to end since this object was created.
  [[nodiscard]] bool ended();
  [[nodiscard]] const os::Fd& fd() const noexcept { return signals_.fd(); }

 private:
  explicit Interruption(os::SignalQueue signals) : signals_(std::move(signals)) {}
  os::SignalQueue signals_;
  bool ended_ = false;
};

/// The problem that a benchmark returns if the user has asked `takt bench` to end.
Problem asked_to_end();

/// Starts "takt" or "takt-node" from the folder of this program. The started program uses only the loopback
/// interface, unless TAKT_INTERFACE is set.
Result<os::Child> start_beside(const std::string& program, const std::vector<std::string>& arguments,
                               bool capture_output);

/// Runs "takt" or "takt-node" until it ends, and returns its standard output. If its exit status is not 0,
/// fails with its standard error. If the user asks `takt bench` to end, this function ends the started
/// program and fails.
Result<std::string> run_beside(const std::string& program, const std::vector<std::string>& arguments,
                               Interruption& interruption);

/// Runs stress-ng on all CPUs during the lifetime of this object. If stress-ng is not installed, start()
/// fails and names the package.
class Load {
 public:
  static Result<Load> start();
  Load(Load&&) = default;
  Load& operator=(Load&&) = delete;
  ~Load();
  /// The command line of stress-ng, for the report.
  static std::string words();

 private:
  explicit Load(os::Child child) : child_(std::move(child)) {}
  os::Child child_;
};

}  // namespace takt::bench
