// A progress line for commands that take longer than a second.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

#include "terminal/screen_style.hpp"

namespace takt::tool {

/// A line on standard error that each update redraws in place. The destructor removes it. If standard error
/// is not a terminal, nothing is shown.
class Progress {
 public:
  Progress();
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// True if standard error is a terminal. If not, the caller need not compute the progress.
  [[nodiscard]] bool is_seen() const noexcept { return seen_; }
  /// True if the line is due for an update. Updates come at most five times a second.
  [[nodiscard]] bool is_due() const;
  /// Shows this text as the progress line, cut to the width of the terminal.
  void show(const std::string& text);
  /// Removes the progress line, so that the caller can write other output.
  void clear();
  /// Prints a permanent line above the progress line.
  void keep(const std::string& text);

 private:
  const bool seen_;
  std::string shown_;
  Instant shown_at_{};
};

/// A progress bar with the share in percent, followed by the text `of`: "[####......]  42 %  OF". A share
/// outside 0 to 1 is clamped.
std::string share_text(double share, const std::string& of, ScreenStyle style);

/// The last report of a device during the bring-up of a cell.
struct BroughtUp {
  std::string device;
  std::string state;                           ///< for example "preparing"
  std::map<std::string, std::string> modules;  ///< the state of each module, by the module's name
};

/// Follows the devices of a cell until all modules of the cell run.
class BringUp {
 public:
  /// `modules` is the number of modules in the whole cell.
  explicit BringUp(std::size_t modules) : modules_(modules) {}

  /// Returns a line for each change since the last call. A change is a module that reached START or
  /// EXECUTING, or a device whose state changed.
  std::vector<std::string> news(const std::vector<BroughtUp>& devices);
  /// The text of the progress line: the progress of the whole cell, and the modules that do not run yet.
  [[nodiscard]] std::string text(const std::vector<BroughtUp>& devices, ScreenStyle style) const;

 private:
  std::size_t modules_;
  std::map<std::string, std::string> reported_;  // the last reported state, by DEVICE or DEVICE.MODULE
};

}  // namespace takt::tool
