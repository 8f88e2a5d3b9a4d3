#include <takt/model/field_values.hpp>

#include <algorithm>
#include <string_view>

#include <nlohmann/json.hpp>

#include <takt/core/words.hpp>
#include <takt/model/json.hpp>

namespace takt::model {

namespace {

using Json = nlohmann::ordered_json;

/// Converts the text of a field's value to JSON. Strings, characters and enumerators need no quotes.
Json value_of(const Field& field, const std::string& text) {
  const bool quoted = field.scalar == Scalar::text || field.scalar == Scalar::enumeration ||
                      field.scalar == Scalar::character;
  const bool list = field.sequence != 0 || !field.dimensions.empty();
  const Json value = parse_json(text);
  if (quoted && !list) return value.is_string() ? value : Json(text);
  return value.is_discarded() ? Json(text) : value;
}

}  // namespace

Result<std::string> json_of_words(const Type& type, const std::vector<std::string>& words) {
  Json json = Json::object();
  Problems problems;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos || equals == 0) {
      problems.push_back({type.name, in_quotes(word) + " does not have the form field=value",
                          R"(write field=value, or one object {"field": value})"});
      continue;
    }
    const std::vector<Field>* fields = &type.fields;
    Json* at = &json;
    std::string where = type.name;
    std::string_view path{word.data(), equals};
    while (true) {
      const std::string name{path.substr(0, path.find('.'))};
      const bool last = name.size() == path.size();
      const auto field = std::find_if(fields->begin(), fields->end(),
                                      [&name](const Field& one) { return one.name == name; });
      if (field == fields->end()) {
        std::vector<std::string_view> names;
        for (const Field& one : *fields) names.emplace_back(one.name);
        problems.push_back({where, "has no field " + in_quotes(name), suggestion(name, names)});
        break;
      }
      where += "." + name;
      if (last) {
        if (at->contains(name))
          problems.push_back({where, "is given twice", "give it one value"});
        else
          (*at)[name] = value_of(*field, word.substr(equals + 1));
        break;
      }
      const bool structure =
          field->scalar == Scalar::structure && field->sequence == 0 && field->dimensions.empty();
      Json& inner = (*at)[name];
      if (!structure || (!inner.is_null() && !inner.is_object())) {
        problems.push_back(
            {where, structure ? "is given twice" : "has no named fields", "write its value once, as JSON"});
        break;
      }
      if (inner.is_null()) inner = Json::object();
      at = &inner;
      fields = &field->fields;
      path.remove_prefix(name.size() + 1);
    }
  }
  if (!problems.empty()) return problems;
  return json_text(json);
}

Result<std::string> json_of_input(const Type& type, const std::vector<std::string>& words) {
  if (words.size() == 1 && words[0].find_first_not_of(" \t\r\n") != std::string::npos &&
      words[0][words[0].find_first_not_of(" \t\r\n")] == '{') {
    return words[0];
  }
  return json_of_words(type, words);
}

}  // namespace takt::model
