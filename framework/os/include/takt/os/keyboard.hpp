// Reads keys from a terminal one by one, as the user presses them.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include <takt/core/time.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// Reads the keyboard of the terminal. While this object exists, the terminal does not echo keys, passes each
/// key at once instead of whole lines, and passes Ctrl-Z as a key. The destructor restores the terminal.
class Keyboard {
 public:
  // The keys that next() returns and that are not characters. Their values are larger than any byte.
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

  /// Returns true if both standard input and standard output are a terminal.
  static bool is_terminal();

  /// Returns the next key: a byte of a character, or one of the constants above; none if no key was pressed.
  /// Skips special keys without a constant. Does not wait. Most special keys begin with the byte ESC; so
  /// kEscape is returned only if no other byte has followed it for 60 ms.
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

/// Removes the first key from the bytes in `typed`, and returns it. Returns none if `typed` contains no key,
/// or only the beginning of one. If `whole` is true, no more bytes will follow, so a single escape is a key.
std::optional<int> take_key(std::string& typed, bool whole);

/// Returns the width in columns of the terminal on standard error; 0 if standard error is not a terminal, 80
/// if the width is not known.
std::size_t error_columns();

}  // namespace takt::os
