// A line that says how far something is, for what takes longer than a second.
#pragma once

#include <cstddef>
#include <string>

#include <takt/core/time.hpp>

#include "screen_style.hpp"

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

 private:
  const bool seen_;
  std::string shown_;
  Instant shown_at_{};
};

/// "[####......]  42 %  " and what it is a share of; a share below 0 counts as 0, above 1 as 1.
std::string share_text(double share, const std::string& of, ScreenStyle style);

}  // namespace takt::tool
