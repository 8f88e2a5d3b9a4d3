#include "terminal/terminal.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include <takt/core/control_character.hpp>
#include <takt/core/words.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>

namespace takt::tool {

namespace {

/// Returns the length of the colour code at the start of `text`, such as \x1b[33m; 0 if there is none.
std::size_t colour_length(std::string_view text) {
  constexpr std::string_view kBegin = "\x1b[";
  if (!text.starts_with(kBegin)) return 0;
  const std::size_t end = text.find_first_not_of("0123456789;", kBegin.size());
  return end != std::string_view::npos && text[end] == 'm' ? end + 1 : 0;
}

/// Escapes all control characters but line feeds, tabs and, if `colour` is set, colour codes.
std::string without_control(std::string_view text, bool colour) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const std::size_t code = colour ? colour_length(text) : 0;
    const std::size_t length = utf8_length(text);
    const std::string_view part = text.substr(0, std::max<std::size_t>({code, length, 1}));
    const bool shown =
        code != 0 || part == "\n" || part == "\t" || (length != 0 && !is_control_character(part));
    result += shown ? std::string{part} : on_one_line(part);
    text.remove_prefix(part.size());
  }
  return result;
}

int first_error = 0;  // the value of errno when print_unchanged() failed for the first time

}  // namespace

Style terminal_style() { return {.colour = os::output_is_terminal() && os::environment("NO_COLOR").empty()}; }

bool print(const std::string& text) {
  return print_unchanged(without_control(text, terminal_style().colour));
}

bool print_unchanged(std::string_view text) {
  const bool written =
      std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (!written && first_error == 0) first_error = errno;
  return written;
}

void tell(std::string_view line) { std::fprintf(stderr, "%s\n", on_one_line(line).c_str()); }

int finish(int status) {
  if (first_error == 0) return status;
  if (first_error == EPIPE) return kNoReader;
  std::fprintf(stderr, "error: cannot write the output: %s\n", std::strerror(first_error));
  return status == 0 ? 1 : status;
}

}  // namespace takt::tool
