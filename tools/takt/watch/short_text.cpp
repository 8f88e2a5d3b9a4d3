#include "watch/short_text.hpp"

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/model/json.hpp>

namespace takt::tool::watch {

namespace {

void add(std::string& text, const nlohmann::ordered_json& value, bool outermost = false) {
  if (value.is_number_float()) {
    text += fmt::format("{:.4g}", value.get<double>());
  } else if (value.is_structured()) {
    if (!outermost) text += value.is_object() ? '{' : '[';
    bool is_first = true;
    for (const auto& [name, member] : value.items()) {
      if (!std::exchange(is_first, false)) text += ", ";
      if (value.is_object()) text += name + ": ";
      add(text, member);
    }
    if (!outermost) text += value.is_object() ? '}' : ']';
  } else {
    text += model::json_text(value);
  }
}

}  // namespace

std::string short_text(const std::string& sample) {
  const auto value = model::parse_json(sample);
  if (value.is_discarded()) return sample;
  std::string text;
  add(text, value, value.is_object());
  return text;
}

}  // namespace takt::tool::watch
