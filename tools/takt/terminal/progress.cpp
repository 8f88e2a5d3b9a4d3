#include "terminal/progress.hpp"

#include <cstdio>

#include <takt/os/clock.hpp>
#include <takt/os/keyboard.hpp>

#include "terminal/screen_style.hpp"
#include "terminal/terminal.hpp"
#include "watch/line.hpp"

namespace takt::tool {

Progress::Progress() : seen_(os::error_columns() > 0) {}

bool Progress::is_due() const { return seen_ && os::now() - shown_at_ >= std::chrono::milliseconds{200}; }

void Progress::show(const std::string& text) {
  if (!seen_) return;
  // Leave the last column free, because a character written there may move the cursor to the next line.
  const std::size_t columns = os::error_columns();
  shown_ = watch::Line{}.add(text).shown(columns > 1 ? columns - 1 : 1, {.unicode = is_utf8()});
  shown_at_ = os::now();
  std::fprintf(stderr, "\r\033[K%s", shown_.c_str());
  std::fflush(stderr);
}

void Progress::clear() {
  if (shown_.empty()) return;
  shown_.clear();
  std::fprintf(stderr, "\r\033[K");
  std::fflush(stderr);
}

void Progress::keep(const std::string& text) {
  if (!seen_) return;
  const std::string before = shown_;
  clear();
  tell(text);
  if (!before.empty()) show(before);
}

}  // namespace takt::tool
