#include <takt/model/type.hpp>

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/core/cdr.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>

namespace takt::model {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 15> kWords{
    "boolean",        "octet",  "char",          "int8",      "short",
    "unsigned short", "long",   "unsigned long", "long long", "unsigned long long",
    "float",          "double", "string",        "enum",      "struct"};

// ---- Sizes

/// The number of bytes that a value adds to a sample, indexed by the value's start offset modulo 8. Padding
/// depends only on this offset.
using Span = std::array<std::size_t, 8>;

/// Stands for this size and all larger ones. It exceeds every limit, and it is small enough that sums of
/// sizes do not overflow.
constexpr std::size_t kTooMany = 4 * kMaxSampleSize;

Span both(const Span& first, const Span& second) {
  Span sum{};
  for (std::size_t at = 0; at < sum.size(); ++at)
    sum[at] = std::min(first[at] + second[(at + first[at]) % sum.size()], kTooMany);
  return sum;
}

Span repeated(Span one, std::size_t n) {
  Span sum{};
  for (; n > 0; n /= 2) {
    if (n % 2 == 1) sum = both(sum, one);
    one = both(one, one);
  }
  return sum;
}

std::size_t saturated_product(const std::vector<std::size_t>& dimensions) {
  std::size_t result = 1;
  for (const std::size_t n : dimensions) result = n == 0 || result > kTooMany / n ? kTooMany : result * n;
  return result;
}

Span aligned(std::size_t size, std::size_t more = 0) {
  Span span{};
  for (std::size_t at = 0; at < span.size(); ++at) span[at] = cdr_padding(at, size) + size + more;
  return span;
}

std::size_t size_of(Scalar scalar) {
  switch (scalar) {
    case Scalar::boolean:
    case Scalar::octet:
    case Scalar::character:
    case Scalar::int8:
      return 1;
    case Scalar::int16:
    case Scalar::uint16:
      return 2;
    case Scalar::int64:
    case Scalar::uint64:
    case Scalar::float64:
      return 8;
    default:
      return 4;
  }
}

Span span_of(const std::vector<Field>& fields);

Span span_of(const Field& field) {
  Span one = field.scalar == Scalar::structure ? span_of(field.fields)
             : field.scalar == Scalar::text    ? aligned(4, std::min(field.bound, kTooMany) + 1)
                                               : aligned(size_of(field.scalar));
  if (field.sequence > 0) {
    const std::size_t n = std::min(field.sequence, kTooMany);
    one = both(aligned(4), repeated(repeated(one, saturated_product(field.elements)), n));
  }
  return repeated(one, saturated_product(field.dimensions));
}

Span span_of(const std::vector<Field>& fields) {
  Span sum{};
  for (const Field& field : fields) sum = both(sum, span_of(field));
  return sum;
}

// ---- From JSON

bool is_name(std::string_view text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  return !text.empty() && text.size() <= kMaxTypeName && is_letter(text[0]) &&
         std::all_of(text.begin(), text.end(),
                     [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); });
}

/// Returns true if the text is a type name, such as "motion::JointState".
bool is_type_name(std::string_view text) {
  if (text.size() > kMaxTypeName) return false;
  for (std::size_t at = text.find("::"); at != std::string_view::npos; at = text.find("::")) {
    if (!is_name(text.substr(0, at))) return false;
    text.remove_prefix(at + 2);
  }
  return is_name(text);
}

class TypeReader {
 public:
  std::optional<Type> type(const Json& json) {
    Type type;
    if (!json.is_object()) {
      problem("", "the description is not an object", R"(write {"name": ..., "fields": [...]})");
      return std::nullopt;
    }
    type.name = name_of(json, "", "name", is_type_name);
    type.fields = fields_of(json, type.name, 1);
    only(json, type.name, {"name", "fields"});
    return type;
  }
  Problems problems;

 private:
  void problem(const std::string& where, std::string what, std::string fix) {
    // An author does not need more than 100 problems of one type.
    if (problems.size() < 100)
      problems.push_back({where.empty() ? "the type" : where, std::move(what), std::move(fix)});
  }

  void only(const Json& json, const std::string& where, const std::set<std::string_view>& members) {
    for (const auto& [name, value] : json.items()) {
      if (name == "key") {
        problem(where, "is a key", "remove the key: port types have none");
      } else if (!members.contains(name)) {
        problem(where, "has the unknown member " + in_quotes(name),
                "remove it: Takt cannot tell whether it changes the type");
      }
    }
  }

  template <class IsName>
  std::string name_of(const Json& json, const std::string& where, const char* member, IsName is_right) {
    const auto found = json.find(member);
    if (found != json.end() && found->is_string() && is_right(found->template get_ref<const std::string&>()))
      return found->template get<std::string>();
    problem(where, std::string{"has no valid \""} + member + '"', "write an IDL name");
    return "?";
  }

  std::vector<Field> fields_of(const Json& json, const std::string& where, std::size_t nesting) {
    const auto found = json.find("fields");
    if (found == json.end() || !found->is_array() || found->empty()) {
      problem(where, "has no fields", "a struct must have at least one field");
      return {};
    }
    if (nesting > kMaxNesting) {
      problem(where, "is a struct that is nested too deep",
              "nest at most " + std::to_string(kMaxNesting) + " structs");
      return {};
    }
    std::vector<Field> fields;
    std::set<std::string> names;
    for (const Json& each : *found) {
      if (++fields_ > kMaxFields) {
        if (fields_ == kMaxFields + 1)
          problem(where, "has too many fields", "a type has at most " + std::to_string(kMaxFields));
        return fields;
      }
      fields.push_back(field_of(each, where, nesting));
      if (!names.insert(fields.back().name).second && fields.back().name != "?")
        problem(where + '.' + fields.back().name, "appears twice", "choose another name");
    }
    return fields;
  }

  Field field_of(const Json& json, const std::string& holder, std::size_t nesting) {
    Field field;
    if (!json.is_object()) {
      problem(holder, "has a field that is not an object", R"(write {"name": ..., "type": ...})");
      return field;
    }
    field.name = name_of(json, holder, "name", is_name);
    const std::string where = holder + '.' + field.name;
    std::set<std::string_view> members{"name", "type", "unit", "array", "sequence", "elements"};

    const auto word = json.find("type");
    const auto* scalar = word != json.end() && word->is_string()
                             ? std::find(kWords.begin(), kWords.end(), word->get_ref<const std::string&>())
                             : kWords.end();
    if (scalar == kWords.end()) {
      problem(where, "has no known type", "use an IDL type, such as double");
      return field;
    }
    field.scalar = static_cast<Scalar>(scalar - kWords.begin());
    if (json.contains("unit")) field.unit = unit_of(json["unit"], where, field.scalar);
    field.dimensions = sizes_of(json, where, "array");
    field.elements = sizes_of(json, where, "elements");
    if (json.contains("sequence"))
      field.sequence = size_of_member(json["sequence"], where, "a sequence without a bound");
    if (!field.elements.empty() && field.sequence == 0)
      problem(where, "has \"elements\" but is not a sequence",
              "write the dimensions of an array in \"array\"");

    if (field.scalar == Scalar::text) {
      members.insert("bound");
      if (json.contains("bound")) {
        field.bound = size_of_member(json["bound"], where, "a string without a bound");
      } else {
        problem(where, "is a string without a bound", "add one, as in string<64>");
      }
    }
    if (field.scalar == Scalar::enumeration || field.scalar == Scalar::structure) {
      members.insert("of");
      field.type_name = name_of(json, where, "of", is_type_name);
    }
    if (field.scalar == Scalar::enumeration) {
      members.insert("enumerators");
      field.enumerators = enumerators_of(json, where);
    }
    if (field.scalar == Scalar::structure) {
      members.insert("fields");
      if (field.sequence > 0) ++sequences_;
      field.fields = fields_of(json, where, nesting + 1);
      if (field.sequence > 0) --sequences_;
    }
    if (field.sequence > 0 && sequences_ > 0)
      problem(where, "is a sequence within a sequence", "use an array of sequences");
    only(json, where, members);
    return field;
  }

  std::string unit_of(const Json& json, const std::string& where, Scalar scalar) {
    const std::string unit = json.is_string() ? json.get<std::string>() : "";
    const bool printable = std::all_of(unit.begin(), unit.end(), [](char c) { return c >= ' ' && c <= '~'; });
    if (unit.empty() || unit.size() > kMaxUnit || !printable)
      problem(where, "has no valid \"unit\"",
              "write 1 to " + std::to_string(kMaxUnit) + " printable ASCII characters");
    if (scalar == Scalar::boolean || scalar == Scalar::character || scalar >= Scalar::text)
      problem(where, "has a unit but is not a number", "remove the unit");
    return unit;
  }

  std::size_t size_of_member(const Json& json, const std::string& where, const char* what) {
    if (json.is_number_unsigned() && json.get<std::uint64_t>() >= 1 &&
        json.get<std::uint64_t>() <= kMaxSampleSize)
      return json.get<std::size_t>();
    problem(where, std::string{"is "} + what, "write a number from 1 to " + std::to_string(kMaxSampleSize));
    return 1;
  }

  std::vector<std::size_t> sizes_of(const Json& json, const std::string& where, const char* member) {
    const auto found = json.find(member);
    if (found == json.end()) return {};
    std::vector<std::size_t> sizes;
    if (!found->is_array() || found->empty()) {
      problem(where, std::string{"has no size in \""} + member + '"', "write a list of sizes");
      return {};
    }
    for (const Json& each : *found) sizes.push_back(size_of_member(each, where, "an array without a size"));
    return sizes;
  }

  std::vector<std::string> enumerators_of(const Json& json, const std::string& where) {
    const auto found = json.find("enumerators");
    std::vector<std::string> enumerators;
    std::set<std::string> names;
    if (found != json.end() && found->is_array()) {
      for (const Json& each : *found) {
        if (!each.is_string() || !is_name(each.get_ref<const std::string&>()) ||
            !names.insert(each.get<std::string>()).second) {
          problem(where, "has an enumerator without a unique name", "write a unique IDL name");
          return {"?"};
        }
        enumerators.push_back(each.get<std::string>());
      }
    }
    if (enumerators.empty())
      problem(where, "has no enumerators", "an enum must have at least one enumerator");
    return enumerators;
  }

  std::size_t fields_ = 0;
  int sequences_ = 0;  // the number of sequences that contain the present field
};

Json fields_json(const std::vector<Field>& fields) {
  Json list = Json::array();
  for (const Field& field : fields) {
    Json json{{"name", field.name}, {"type", to_text(field.scalar)}};
    if (!field.unit.empty()) json["unit"] = field.unit;
    if (field.scalar == Scalar::text) json["bound"] = field.bound;
    if (!field.dimensions.empty()) json["array"] = field.dimensions;
    if (field.sequence > 0) json["sequence"] = field.sequence;
    if (!field.elements.empty()) json["elements"] = field.elements;
    if (!field.type_name.empty()) json["of"] = field.type_name;
    if (field.scalar == Scalar::enumeration) json["enumerators"] = field.enumerators;
    if (field.scalar == Scalar::structure) json["fields"] = fields_json(field.fields);
    list.push_back(std::move(json));
  }
  return list;
}

}  // namespace

const char* to_text(Scalar scalar) { return kWords.at(static_cast<std::size_t>(scalar)); }

Result<Type> parse_type(const std::string& text) {
  if (text.size() > kMaxDescription)
    return Problem{"the type", "the description has " + std::to_string(text.size()) + " bytes",
                   "a description has at most " + std::to_string(kMaxDescription) + " bytes"};
  const Json json = parse_json(text);
  if (json.is_discarded()) return Problem{"the type", "the description is not JSON", {}};
  TypeReader reader;
  auto type = reader.type(json);
  if (!reader.problems.empty()) return std::move(reader.problems);
  if (const std::size_t size = max_size(*type); size > kMaxSampleSize)
    return Problem{type->name, "a sample has more than " + std::to_string(kMaxSampleSize) + " bytes",
                   "reduce the bounds of its strings and sequences"};
  return std::move(*type);
}

std::string to_text(const Type& type) {
  return json_text({{"name", type.name}, {"fields", fields_json(type.fields)}});
}

std::size_t max_size(const Type& type) { return padded_sample(kEncapsulation + span_of(type.fields)[0]); }

}  // namespace takt::model
