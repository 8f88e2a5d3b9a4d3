#include <takt/client/port_names.hpp>

#include <algorithm>

#include <takt/core/words.hpp>

namespace takt::client {

bool matches(std::string_view pattern, std::string_view name) {
  // Compare character by character. At a mismatch, let the * that was reached last match one more character,
  // and compare the rest of the pattern again.
  std::size_t p = 0;
  std::size_t n = 0;
  std::size_t star = std::string_view::npos;
  std::size_t taken = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      taken = n;
    } else if (p < pattern.size() && pattern[p] == name[n]) {
      ++p;
      ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++taken;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

bool may_match(std::string_view pattern, std::string_view device) {
  const std::size_t star = pattern.find('*');
  const std::size_t dot = pattern.find('.');
  if (dot < star) return pattern.substr(0, dot) == device;
  return device.substr(0, star) == pattern.substr(0, star);
}

Result<PortName> parse_port(const std::string& name) {
  const std::size_t first = name.find('.');
  const std::size_t second = first == std::string::npos ? first : name.find('.', first + 1);
  const bool three = second != std::string::npos && first > 0 && second > first + 1 &&
                     second + 1 < name.size() && name.find('.', second + 1) == std::string::npos;
  if (!three) return fail(in_quotes(name) + " is not a port name", "write DEVICE.MODULE.PORT, or DEVICE.*");
  return PortName{name.substr(0, first), name.substr(first + 1, second - first - 1), name.substr(second + 1)};
}

Result<void> check_ports(const std::vector<std::string>& names) {
  Problems problems;
  if (names.empty()) problems.push_back(fail("no port is given", "write DEVICE.MODULE.PORT, or DEVICE.*"));
  for (const std::string& name : names) {
    if (is_pattern(name)) continue;
    if (const auto port = parse_port(name); !port)
      problems.insert(problems.end(), port.problems().begin(), port.problems().end());
  }
  if (problems.empty()) return {};
  return problems;
}

}  // namespace takt::client
