#include "whole_file.hpp"

#include <array>
#include <cstdint>
#include <cstdio>

#include <takt/os/files.hpp>
#include <takt/os/writers.hpp>

namespace takt::node {

namespace {
// Computes FNV-1a, which detects accidental but not deliberate changes.
std::string checksum_text(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(hash));
  return digits.data();
}
}  // namespace

Result<void> write_whole(const std::string& path, const std::string& format, const std::string& body) {
  return os::replace_file(path, format + " " + checksum_text(body) + "\n" + body);
}

Result<std::optional<std::string>> read_whole(const std::string& path, const std::string& format,
                                              std::size_t most, const Problem& damaged) {
  if (auto writers = os::check_writers(path); !writers) return writers.problems();
  const auto content = os::read_file(path, most);
  if (!content) return content.problems();
  if (!*content) return std::optional<std::string>{};
  const auto because = [&damaged](const std::string& how) {
    return Problem{damaged.where, damaged.what + ": " + how, damaged.fix};
  };
  const std::size_t line = (*content)->find('\n');
  if (line == std::string::npos || !(*content)->starts_with(format + " "))
    return because("it does not begin with \"" + format + "\"");
  std::string body = (*content)->substr(line + 1);
  if ((*content)->substr(0, line) != format + " " + checksum_text(body))
    return because("its checksum is wrong");
  return std::optional{std::move(body)};
}

}  // namespace takt::node
