// Reads the keys of a terminal one by one as they are pressed.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include <takt/core/time.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// While this object exists, the terminal does not echo keys, does not wait for the end of a line, and passes
/// Ctrl-Z as a key. The destructor restores the terminal.
class Keyboard {
 public:
  // Keys that are not characters; their values are beyond every byte.
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

  /// Whether standard input and output are a terminal.
  static bool is_terminal();

  /// The next key: a byte of a character or one of the keys above; none if no key was pressed. Skips other
  /// special keys. Does not wait. A lone escape is returned only after nothing has followed it for a while.
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

/// Removes and returns the first key of the typed bytes; none if there are no bytes, or only the beginning of
/// a key. `whole` means that no more bytes follow, so an escape is a key of its own.
std::optional<int> take_key(std::string& typed, bool whole);

/// The width of the terminal on standard error, in columns; 0 if that is not a terminal, 80 if the width is
/// not known.
std::size_t error_columns();

}  // namespace takt::os
