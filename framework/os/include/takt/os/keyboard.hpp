// A terminal's keys, one by one, as they are pressed.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include <takt/core/time.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// While it exists the terminal neither shows what is typed nor waits for a line's end, and Ctrl-Z is a key
/// like others; afterwards it is as it was.
class Keyboard {
 public:
  // Those that are no character: beyond every byte.
  static constexpr int kUp = 256;
  static constexpr int kDown = 257;
  static constexpr int kPageUp = 258;
  static constexpr int kPageDown = 259;
  static constexpr int kHome = 260;
  static constexpr int kEnd = 261;
  static constexpr int kEscape = 262;
  static constexpr int kBackspace = 263;

  struct Size {
    std::size_t columns = 80;
    std::size_t rows = 24;
  };

  Keyboard();
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  /// Standard input and output are a terminal.
  static bool is_terminal();

  /// The next key that was pressed, a byte of a character or one of those above; none when none was. What a
  /// terminal sends for a key that is not among them is passed over. Does not wait: a lone escape is told
  /// only when nothing has followed it for a while.
  std::optional<int> next();
  [[nodiscard]] Size size() const;
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }

 private:
  struct Before;
  std::unique_ptr<Before> before_;
  Fd fd_;
  std::string typed_;
  Instant typed_at_{};
};

/// The first key of what was typed, which is taken off it; none when there is nothing, or only the beginning
/// of a key. `whole`: nothing is going to follow, so an escape is one.
std::optional<int> take_key(std::string& typed, bool whole);

/// The columns of the terminal that standard error is; 0: it is none. 80 where the terminal does not say.
std::size_t error_columns();

}  // namespace takt::os
