// Programs that run while something is measured: `takt` and its nodes, as they are used, and a load beside
// them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/process.hpp>
#include <takt/os/signals.hpp>

namespace takt::bench {

/// Whether somebody asks this program to end (Ctrl-C) while others run for it. One at a time, before there
/// are threads.
class Patience {
 public:
  static Result<Patience> create();
  /// Also of requests that came earlier.
  [[nodiscard]] bool ended();
  [[nodiscard]] const os::Fd& fd() const noexcept { return signals_.fd(); }

 private:
  explicit Patience(os::SignalQueue signals) : signals_(std::move(signals)) {}
  os::SignalQueue signals_;
  bool ended_ = false;
};

/// What is said then.
Problem asked_to_end();

/// Starts a program that lies beside this one ("takt", "takt-node"), on the loopback interface alone unless
/// TAKT_INTERFACE says otherwise.
Result<os::Child> start_beside(const std::string& program, const std::vector<std::string>& arguments,
                               bool capture_output);

/// Runs such a program to its end and returns what it wrote to standard output. Fails with what it wrote to
/// standard error unless its status is 0, and when somebody loses patience: it is asked to end then.
Result<std::string> run_beside(const std::string& program, const std::vector<std::string>& arguments,
                               Patience& patience);

/// stress-ng on all processors while it lives. Fails, with the package to install, where there is none.
class Load {
 public:
  static Result<Load> start();
  Load(Load&&) = default;
  Load& operator=(Load&&) = delete;
  ~Load();
  /// What it was started with, for the report.
  static std::string words();

 private:
  explicit Load(os::Child child) : child_(std::move(child)) {}
  os::Child child_;
};

}  // namespace takt::bench
