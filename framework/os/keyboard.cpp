#include <takt/os/keyboard.hpp>

#include <fcntl.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <utility>

namespace takt::os {

struct Keyboard::Before {
  termios settings{};
  bool known = false;
};

Keyboard::Keyboard() : before_(std::make_unique<Before>()), fd_(fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3)) {
  before_->known = tcgetattr(STDIN_FILENO, &before_->settings) == 0;
  if (!before_->known) return;
  termios raw = before_->settings;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_cc[VMIN] = 0;  // read() does not wait
  raw.c_cc[VTIME] = 0;
  tcsetattr(STDIN_FILENO, TCSANOW, &raw);
}

Keyboard::~Keyboard() {
  if (before_->known) tcsetattr(STDIN_FILENO, TCSANOW, &before_->settings);
}

bool Keyboard::is_terminal() { return isatty(STDIN_FILENO) == 1 && isatty(STDOUT_FILENO) == 1; }

std::optional<char> Keyboard::next() {
  std::array<char, 64> bytes{};
  if (const ssize_t n = ::read(fd_.get(), bytes.data(), bytes.size()); n > 0)
    typed_.append(bytes.data(), static_cast<std::size_t>(n));
  if (typed_.empty()) return std::nullopt;
  for (const auto& [sequence, key] : {std::pair{"\033[A", kUp}, std::pair{"\033[B", kDown}}) {
    if (typed_.rfind(sequence, 0) != 0) continue;
    typed_.erase(0, 3);
    return key;
  }
  const char key = typed_.front();
  typed_.erase(0, 1);
  return key;
}

Keyboard::Size Keyboard::size() const {
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) return {};
  return {size.ws_col, size.ws_row};
}

}  // namespace takt::os
