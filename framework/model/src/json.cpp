#include <takt/model/json.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

#include <nlohmann/json.hpp>

#include <takt/core/control_character.hpp>
#include <takt/core/words.hpp>

namespace takt::model {

namespace {

/// Returns the number of a control character, which has at most three bytes in UTF-8.
std::uint32_t code_point(std::string_view character) {
  const auto bits = [character](std::size_t i, std::uint32_t mask) {
    return static_cast<std::uint32_t>(static_cast<unsigned char>(character[i])) & mask;
  };
  if (character.size() == 1) return bits(0, 0x7f);
  if (character.size() == 2) return bits(0, 0x1f) << 6U | bits(1, 0x3f);
  return bits(0, 0x0f) << 12U | bits(1, 0x3f) << 6U | bits(2, 0x3f);
}

}  // namespace

nlohmann::ordered_json parse_json(std::string_view text) {
  return nlohmann::ordered_json::parse(text, nullptr, false);
}

std::string json_text(const nlohmann::ordered_json& value) {
  const std::string dumped = value.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string text;
  text.reserve(dumped.size());
  for (std::string_view rest = dumped; !rest.empty();) {
    const std::string_view character = rest.substr(0, std::max<std::size_t>(1, utf8_length(rest)));
    if (is_control_character(character)) {
      std::array<char, 7> escaped{};
      std::snprintf(escaped.data(), escaped.size(), "\\u%04x", code_point(character));
      text += escaped.data();
    } else {
      text += character;
    }
    rest.remove_prefix(character.size());
  }
  return text;
}

std::optional<std::uint64_t> whole_number(const nlohmann::ordered_json& value) {
  if (!value.is_number_integer() || (!value.is_number_unsigned() && value.get<std::int64_t>() < 0))
    return std::nullopt;
  return value.get<std::uint64_t>();
}

}  // namespace takt::model
