// A terminal's keys, one by one, as they are pressed.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include <takt/os/fd.hpp>

namespace takt::os {

/// While it exists the terminal neither shows what is typed nor waits for a line's end; afterwards it is as
/// it was.
class Keyboard {
 public:
  static constexpr char kUp = 1;  ///< the arrow keys
  static constexpr char kDown = 2;

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

  /// The next key that was pressed; none when none was. Does not wait.
  std::optional<char> next();
  [[nodiscard]] Size size() const;
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }

 private:
  struct Before;
  std::unique_ptr<Before> before_;
  Fd fd_;
  std::string typed_;
};

}  // namespace takt::os
