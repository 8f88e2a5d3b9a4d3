#include <algorithm>

#include <takt/model/validate.hpp>

namespace takt::model {

bool is_valid_name(std::string_view name) {
  // This code does not use isalpha(), because its result depends on the locale.
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto later = [letter](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '-'; };
  return !name.empty() && name.size() <= kMaxNameLength && letter(name[0]) &&
         std::all_of(name.begin(), name.end(), later);
}

bool is_valid_topic(std::string_view topic) {
  return !topic.empty() && topic.size() <= kMaxTopic &&
         std::all_of(topic.begin(), topic.end(), [](char c) { return c > ' ' && c <= '~'; });
}

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Returns true if the text is a number from 0 to `most`, without a sign and without leading zeros.
bool is_number_up_to(std::string_view text, int most) {
  if (text.empty() || text.size() > 5 || !std::all_of(text.begin(), text.end(), is_digit)) return false;
  if (text.size() > 1 && text[0] == '0') return false;
  int number = 0;
  for (const char c : text) number = number * 10 + (c - '0');
  return number <= most;
}

/// Returns the number of parts of a text that are separated by dots; 0 if is_part() is false for one of them.
/// A text without a dot is one part.
template <class IsPart>
std::size_t count_parts(std::string_view text, IsPart is_part) {
  std::size_t parts = 0;
  while (true) {
    const std::size_t dot = text.find('.');
    if (!is_part(text.substr(0, dot))) return 0;
    ++parts;
    if (dot == std::string_view::npos) return parts;
    text.remove_prefix(dot + 1);
  }
}

}  // namespace

bool is_valid_host(std::string_view host) {
  if (host.size() > kMaxHost) return false;
  const auto is_label = [](std::string_view label) {
    const auto allowed = [](char c) {
      return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '_';
    };
    return !label.empty() && label.size() <= kMaxNameLength && label.front() != '-' && label.back() != '-' &&
           std::all_of(label.begin(), label.end(), allowed);
  };
  // A text of only digits and dots must be a complete IPv4 address: 10.0.1 is not a valid host.
  const bool address = std::all_of(host.begin(), host.end(), [](char c) { return is_digit(c) || c == '.'; });
  if (!address) return count_parts(host, is_label) > 0;
  return count_parts(host, [](std::string_view part) { return is_number_up_to(part, 255); }) == 4;
}

bool is_valid_server(std::string_view server) {
  const std::size_t colon = server.rfind(':');
  if (colon == std::string_view::npos || !is_valid_host(server.substr(0, colon))) return false;
  const std::string_view port = server.substr(colon + 1);
  return port != "0" && is_number_up_to(port, 65535);
}

std::string file_stem(std::string_view filename) {
  const std::size_t slash = filename.rfind('/');
  if (slash != std::string_view::npos) filename.remove_prefix(slash + 1);
  const std::size_t dot = filename.rfind('.');
  if (dot != std::string_view::npos && dot != 0) filename = filename.substr(0, dot);
  return std::string{filename};
}

}  // namespace takt::model
