#include <takt/os/keyboard.hpp>

#include <fcntl.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>

#include <takt/os/clock.hpp>

namespace takt::os {

namespace {

/// All bytes that a terminal sends for one key arrive within this time, even over a slow line.
constexpr std::chrono::milliseconds kTogether{60};

struct Sequence {
  char letter;
  const char* number;
  int key;
};
constexpr std::array kSequences{
    Sequence{'A', "", Keyboard::kUp},      Sequence{'B', "", Keyboard::kDown},
    Sequence{'H', "", Keyboard::kHome},    Sequence{'F', "", Keyboard::kEnd},
    Sequence{'~', "1", Keyboard::kHome},   Sequence{'~', "4", Keyboard::kEnd},
    Sequence{'~', "7", Keyboard::kHome},   Sequence{'~', "8", Keyboard::kEnd},
    Sequence{'~', "5", Keyboard::kPageUp}, Sequence{'~', "6", Keyboard::kPageDown},
};

}  // namespace

struct Keyboard::Before {
  termios settings{};
  bool known = false;
};

Keyboard::Keyboard() : before_(std::make_unique<Before>()), fd_(fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3)) {
  before_->known = tcgetattr(STDIN_FILENO, &before_->settings) == 0;
  if (!before_->known) return;
  termios raw = before_->settings;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  // Otherwise Ctrl-Z would return to the shell while the alternate screen is still shown.
  raw.c_cc[VSUSP] = _POSIX_VDISABLE;
  raw.c_cc[VQUIT] = _POSIX_VDISABLE;  // otherwise Ctrl-\ would end the program without restoring the terminal
  raw.c_cc[VMIN] = 0;                 // read() must not wait
  raw.c_cc[VTIME] = 0;
  tcsetattr(STDIN_FILENO, TCSANOW, &raw);
}

Keyboard::~Keyboard() {
  if (before_->known) tcsetattr(STDIN_FILENO, TCSANOW, &before_->settings);
}

bool Keyboard::is_terminal() { return isatty(STDIN_FILENO) == 1 && isatty(STDOUT_FILENO) == 1; }

std::optional<int> Keyboard::next() {
  std::array<char, 64> bytes{};
  if (const ssize_t n = ::read(fd_.get(), bytes.data(), bytes.size()); n > 0) {
    typed_.append(bytes.data(), static_cast<std::size_t>(n));
    typed_at_ = now();
  }
  return take_key(typed_, now() - typed_at_ >= kTogether);
}

std::optional<int> take_key(std::string& typed, bool whole) {
  constexpr char kEscapeByte = '\033';
  while (!typed.empty()) {
    const auto taken = [&typed](std::size_t bytes, int key) {
      typed.erase(0, bytes);
      return key;
    };
    if (typed[0] == '\b' || typed[0] == '\x7f') return taken(1, Keyboard::kBackspace);
    if (typed[0] != kEscapeByte) return taken(1, static_cast<unsigned char>(typed[0]));
    // A key sequence has the form ESC [ PARAMETERS LETTER, or ESC O LETTER. In any other case the escape is a
    // key by itself.
    const bool sequence = typed.size() > 1 && (typed[1] == '[' || typed[1] == 'O');
    const std::size_t last = sequence ? typed.find_first_not_of("0123456789;", 2) : std::string::npos;
    if (last == std::string::npos) {
      if (!whole && (typed.size() == 1 || sequence)) return std::nullopt;
      return taken(1, Keyboard::kEscape);
    }
    const std::string parameters = typed.substr(2, last - 2);
    const char name = typed[last];
    typed.erase(0, last + 1);
    for (const auto& [letter, number, key] : kSequences) {
      if (name == letter && (letter != '~' || parameters == number)) return key;
    }
  }
  return std::nullopt;
}

Keyboard::Size Keyboard::size() const {
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) return {};
  return {size.ws_col, size.ws_row};
}

std::size_t error_columns() {
  if (isatty(STDERR_FILENO) != 1) return 0;
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace takt::os
