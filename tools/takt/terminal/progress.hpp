// A progress line for commands that take longer than a second.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

#include "terminal/screen_style.hpp"

namespace takt::tool {

/// A line on standard error that is redrawn in place and removed at the end. If standard error is not a
/// terminal, nothing is shown.
class Progress {
 public:
  Progress();
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Whether there is a terminal. If not, the caller need not compute the progress.
  [[nodiscard]] bool is_seen() const noexcept { return seen_; }
  /// Whether it is time for the next update: a few times a second.
  [[nodiscard]] bool is_due() const;
  /// Replaces the line by this text, cut to the width of the terminal.
  void show(const std::string& text);
  /// Removes the line, so that something else can be written there.
  void clear();
  /// Prints a line that stays, above the progress line.
  void keep(const std::string& text);

 private:
  const bool seen_;
  std::string shown_;
  Instant shown_at_{};
};

/// "[####......]  42 %  " followed by `of`. The share is clamped to 0 to 1.
std::string share_text(double share, const std::string& of, ScreenStyle style);

/// A device of a cell during bring-up, as last reported.
struct BroughtUp {
  std::string device;
  std::string state;                           ///< "preparing"
  std::map<std::string, std::string> modules;  ///< states by name
};

/// Follows the devices of a cell until all of its modules run.
class BringUp {
 public:
  /// `modules`: the number of modules of all devices together.
  explicit BringUp(std::size_t modules) : modules_(modules) {}

  /// Returns a line for each change since the last call. A change is a module that reached START or
  /// EXECUTING, or a device whose state changed.
  std::vector<std::string> news(const std::vector<BroughtUp>& devices);
  /// The progress of all devices together, and what is still missing.
  [[nodiscard]] std::string text(const std::vector<BroughtUp>& devices, ScreenStyle style) const;

 private:
  std::size_t modules_;
  std::map<std::string, std::string> reported_;  // states by DEVICE or DEVICE.MODULE
};

}  // namespace takt::tool
