#include "parameters.hpp"

namespace takt::descriptor {

std::string substituted(std::string_view text, const Meaning& meaning, const Unknown& unknown) {
  constexpr std::string_view kOpen = "${";
  std::string result;
  while (true) {
    const std::size_t at = text.find(kOpen);
    if (at == std::string_view::npos) return result.append(text);
    if (at > 0 && text[at - 1] == '$') {  // $${ stands for a literal ${
      result.append(text.substr(0, at - 1)).append(kOpen);
      text.remove_prefix(at + kOpen.size());
      continue;
    }
    result.append(text.substr(0, at));
    text.remove_prefix(at + kOpen.size());
    const std::size_t end = text.find('}');
    if (end == std::string_view::npos) {
      unknown(std::nullopt);
      return result;
    }
    const std::string_view name = text.substr(0, end);
    if (const std::string* value = meaning(name))
      result.append(*value);
    else
      unknown(name);
    text.remove_prefix(end + 1);
  }
}

void substitute(Node& node, const Meaning& meaning,
                const std::function<void(model::Line line, std::optional<std::string_view> name)>& unknown) {
  const auto one = [&](std::string& value, model::Line line) {
    if (value.find("${") == std::string::npos) return;
    value = substituted(value, meaning, [&](std::optional<std::string_view> name) { unknown(line, name); });
  };
  for (Attribute& attribute : node.attributes) one(attribute.value, attribute.line);
  for (Text& text : node.texts) one(text.text, text.line);
  for (Node& child : node.children) substitute(child, meaning, unknown);
}

}  // namespace takt::descriptor
