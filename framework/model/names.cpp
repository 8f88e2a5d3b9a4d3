#include <algorithm>

#include <takt/model/validate.hpp>

namespace takt::model {

bool is_valid_name(std::string_view name) {
  // Not isalpha(): what is a name does not depend on the locale.
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto later = [letter](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '-'; };
  return !name.empty() && name.size() <= kMaxNameLength && letter(name[0]) &&
         std::all_of(name.begin(), name.end(), later);
}

std::string file_stem(std::string_view filename) {
  const std::size_t slash = filename.rfind('/');
  if (slash != std::string_view::npos) filename.remove_prefix(slash + 1);
  const std::size_t dot = filename.rfind('.');
  if (dot != std::string_view::npos && dot != 0) filename = filename.substr(0, dot);
  return std::string{filename};
}

}  // namespace takt::model
