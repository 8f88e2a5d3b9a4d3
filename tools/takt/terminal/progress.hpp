// A line that says how far something is, for what takes longer than a second.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

#include "terminal/screen_style.hpp"

namespace takt::tool {

/// Redrawn in place on standard error, and gone at the end. Where that is no terminal there is nothing of it.
class Progress {
 public:
  Progress();
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Whether anybody sees it: what is not seen need not be made.
  [[nodiscard]] bool is_seen() const noexcept { return seen_; }
  /// Whether it is time for another one: a few times a second.
  [[nodiscard]] bool is_due() const;
  /// In place of the one before, cut to the terminal's width.
  void show(const std::string& text);
  /// The line goes, so that something else can be written there.
  void clear();
  /// A line that stays, above this one.
  void keep(const std::string& text);

 private:
  const bool seen_;
  std::string shown_;
  Instant shown_at_{};
};

/// "[####......]  42 %  " and what it is a share of; a share below 0 counts as 0, above 1 as 1.
std::string share_text(double share, const std::string& of, ScreenStyle style);

/// A device of a cell as it is brought up, as far as was heard.
struct BroughtUp {
  std::string device;
  std::string state;                           ///< "preparing"
  std::map<std::string, std::string> modules;  ///< states by name
};

/// What a cell's devices do until all of its modules run.
class BringUp {
 public:
  /// `modules`: of all devices together.
  explicit BringUp(std::size_t modules) : modules_(modules) {}

  /// The lines to be kept of what has changed since the last time: each module that got to START or
  /// EXECUTING, each device that got to another state.
  std::vector<std::string> news(const std::vector<BroughtUp>& devices);
  /// How far all of it is, and what is waited for.
  [[nodiscard]] std::string text(const std::vector<BroughtUp>& devices, ScreenStyle style) const;

 private:
  std::size_t modules_;
  std::map<std::string, std::string> told_;  // states by DEVICE or DEVICE.MODULE
};

}  // namespace takt::tool
