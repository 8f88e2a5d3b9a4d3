// Checks, prints and builds samples of types that are known only as data at run time.
#include <takt/model/type.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <string_view>
#include <type_traits>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/core/cdr.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>

namespace takt::model {
namespace {

std::size_t product(const std::vector<std::size_t>& dimensions) noexcept {
  std::size_t result = 1;
  for (const std::size_t n : dimensions) result *= n;
  return result;
}

/// Calls `f` with a zero of the C++ type that belongs to the scalar. Returns false, without a call, if the
/// scalar is not a number.
template <class F>
bool with_number(Scalar scalar, F f) {
  switch (scalar) {
    case Scalar::octet:
      f(std::uint8_t{});
      return true;
    case Scalar::int8:
      f(std::int8_t{});
      return true;
    case Scalar::int16:
      f(std::int16_t{});
      return true;
    case Scalar::uint16:
      f(std::uint16_t{});
      return true;
    case Scalar::int32:
      f(std::int32_t{});
      return true;
    case Scalar::uint32:
      f(std::uint32_t{});
      return true;
    case Scalar::int64:
      f(std::int64_t{});
      return true;
    case Scalar::uint64:
      f(std::uint64_t{});
      return true;
    case Scalar::float32:
      f(float{});
      return true;
    case Scalar::float64:
      f(double{});
      return true;
    default:
      return false;
  }
}

// ---- is_sample

void check(const std::vector<Field>& fields, CdrReader& from) noexcept;

/// Checks `n` consecutive values of a field.
void check(const Field& field, std::size_t n, CdrReader& from) noexcept {
  if (with_number(field.scalar, [&](auto zero) { static_cast<void>(from.take_array(sizeof zero, n)); }))
    return;
  switch (field.scalar) {
    case Scalar::character:
      static_cast<void>(from.take_array(1, n));
      break;
    case Scalar::boolean:
      for (; n > 0 && from.ok(); --n) static_cast<void>(from.get_boolean());
      break;
    case Scalar::enumeration:
      for (; n > 0 && from.ok(); --n)
        static_cast<void>(from.get_enumerator(static_cast<std::uint32_t>(field.enumerators.size())));
      break;
    case Scalar::text:
      for (; n > 0 && from.ok(); --n) static_cast<void>(from.get_text(field.bound));
      break;
    default:
      for (; n > 0 && from.ok(); --n) check(field.fields, from);
  }
}

void check(const std::vector<Field>& fields, CdrReader& from) noexcept {
  for (const Field& field : fields) {
    if (field.sequence == 0) {
      check(field, product(field.dimensions), from);
      continue;
    }
    for (std::size_t n = product(field.dimensions); n > 0 && from.ok(); --n)
      check(field, from.get_length(field.sequence) * product(field.elements), from);
  }
}

// ---- sample_json

class Printer {
 public:
  explicit Printer(CdrReader& from) : from_(from) {}

  void structure(const std::vector<Field>& fields) {
    text += '{';
    for (std::size_t i = 0; i < fields.size(); ++i) {
      text += i == 0 ? "\"" : ", \"";
      text += fields[i].name + "\": ";
      array(fields[i].dimensions, 0, [&, &field = fields[i]] { value_or_sequence(field); });
    }
    text += '}';
  }
  std::string text;

 private:
  void list(std::size_t n, const std::function<void()>& each) {
    text += '[';
    for (std::size_t i = 0; i < n; ++i) {
      if (i > 0) text += ", ";
      each();
    }
    text += ']';
  }
  void array(const std::vector<std::size_t>& dimensions, std::size_t from,
             const std::function<void()>& each) {
    if (from == dimensions.size()) return each();
    list(dimensions[from], [&] { array(dimensions, from + 1, each); });
  }
  void value_or_sequence(const Field& field) {
    if (field.sequence == 0) return value(field);
    list(from_.get_length(field.sequence), [&] { array(field.elements, 0, [&] { value(field); }); });
  }
  void value(const Field& field) {
    const auto print = [this](auto zero) {
      const auto number = from_.get<decltype(zero)>();
      if constexpr (std::is_floating_point_v<decltype(zero)>) {
        if (std::isnan(number)) return void(text += "\"NaN\"");
        if (std::isinf(number)) return void(text += number > 0 ? "\"Infinity\"" : "\"-Infinity\"");
      }
      std::array<char, 32> digits{};
      text.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr);
    };
    if (with_number(field.scalar, print)) return;
    switch (field.scalar) {
      case Scalar::boolean:
        text += from_.get_boolean() ? "true" : "false";
        break;
      case Scalar::character: {
        // JSON has no bytes. So write the byte as a Latin-1 character, because in Latin-1 every byte value is
        // a character.
        const auto byte = from_.get<unsigned char>();
        quoted(byte < 0x80 ? std::string(1, static_cast<char>(byte))
                           : std::string{static_cast<char>(0xC0 | byte >> 6),
                                         static_cast<char>(0x80 | (byte & 0x3F))});
        break;
      }
      case Scalar::enumeration:
        quoted(
            field.enumerators.at(from_.get_enumerator(static_cast<std::uint32_t>(field.enumerators.size()))));
        break;
      case Scalar::text:
        quoted(std::string{from_.get_text(field.bound)});
        break;
      default:
        structure(field.fields);
    }
  }
  void quoted(const std::string& characters) { text += json_text(characters); }

  CdrReader& from_;
};

// ---- sample_bytes

using Json = nlohmann::ordered_json;

class Filler {
 public:
  explicit Filler(CdrWriter& to) : to_(to) {}

  /// Writes the fields of a structure from a JSON object. Fields that the object omits, or whose value is
  /// null, become zero.
  void structure(const std::vector<Field>& fields, const Json& json, const std::string& where) {
    if (!json.is_null() && !json.is_object()) problem(where, json, R"(write an object, {"field": value})");
    if (json.is_object()) unknown(fields, json, where);
    for (const Field& field : fields) {
      const Json& member = json.is_object() && json.contains(field.name) ? json[field.name] : missing_;
      array(field.dimensions, 0, member, where + '.' + field.name,
            [&](const Json& each, const std::string& place) { value_or_sequence(field, each, place); });
    }
  }
  Problems problems;

 private:
  using Each = std::function<void(const Json&, const std::string&)>;

  void problem(const std::string& where, const Json& json, std::string fix) {
    const std::string given = json.is_array()    ? "a list of length " + std::to_string(json.size())
                              : json.is_object() ? "an object"
                                                 : json_text(json);
    add({where, "cannot be " + brief(given), std::move(fix)});
  }
  void add(Problem problem) {
    constexpr std::size_t kEnough = 100;
    if (problems.size() < kEnough) problems.push_back(std::move(problem));
  }
  void unknown(const std::vector<Field>& fields, const Json& json, const std::string& where) {
    std::vector<std::string_view> names;
    for (const Field& field : fields) names.push_back(field.name);
    for (const auto& [name, value] : json.items()) {
      if (std::find(names.begin(), names.end(), name) == names.end())
        add({where, "has no field " + in_quotes(name), suggestion(name, names)});
    }
  }

  void array(const std::vector<std::size_t>& dimensions, std::size_t from, const Json& json,
             const std::string& where, const Each& each) {
    if (from == dimensions.size()) return each(json, where);
    const std::size_t n = dimensions[from];
    if (!json.is_null() && (!json.is_array() || json.size() != n)) {
      return problem(where, json, "write a list of length " + std::to_string(n));
    }
    for (std::size_t i = 0; i < n; ++i) {
      array(dimensions, from + 1, json.is_null() ? missing_ : json[i],
            json.is_null() ? where : where + '[' + std::to_string(i) + ']', each);
    }
  }
  void value_or_sequence(const Field& field, const Json& json, const std::string& where) {
    if (field.sequence == 0) return value(field, json, where);
    if (json.is_null()) return to_.put_length(0, field.sequence);
    if (!json.is_array() || json.size() > field.sequence)
      return problem(where, json, "write a list of length at most " + std::to_string(field.sequence));
    to_.put_length(json.size(), field.sequence);
    for (std::size_t i = 0; i < json.size(); ++i) {
      array(field.elements, 0, json[i], where + '[' + std::to_string(i) + ']',
            [&](const Json& each, const std::string& place) { value(field, each, place); });
    }
  }
  void value(const Field& field, const Json& json, const std::string& where) {
    if (with_number(field.scalar, [&](auto zero) { to_.put(number(zero, field, json, where)); })) return;
    switch (field.scalar) {
      case Scalar::boolean:
        if (!json.is_null() && !json.is_boolean()) problem(where, json, "write true or false");
        to_.put(json.is_boolean() && json.get<bool>());
        break;
      case Scalar::character:
        to_.put(character(json, where));
        break;
      case Scalar::enumeration:
        to_.put(enumerator(field, json, where));
        break;
      case Scalar::text: {
        std::string text = json.is_string() ? json.get<std::string>() : std::string{};
        if (!json.is_null() &&
            (!json.is_string() || text.size() > field.bound || text.find('\0') != std::string::npos)) {
          problem(where, json,
                  "write a string of at most " + std::to_string(field.bound) +
                      " bytes that contains no zero byte");
          text.clear();
        }
        to_.put_text(text.c_str(), text.size(), field.bound);
        break;
      }
      default:
        structure(field.fields, json, where);
    }
  }

  template <class T>
  T number(T zero, const Field& field, const Json& json, const std::string& where) {
    if (json.is_null()) return zero;
    if constexpr (std::is_floating_point_v<T>) {
      using Limits = std::numeric_limits<T>;
      if (json == "NaN") return Limits::quiet_NaN();
      if (json == "Infinity") return Limits::infinity();
      if (json == "-Infinity") return -Limits::infinity();
      if (json.is_number() && std::abs(json.get<double>()) <= static_cast<double>(Limits::max()))
        return json.get<T>();
      problem(where, json,
              std::string{"write a number that a "} + to_text(field.scalar) + " can hold, or \"NaN\"");
    } else {
      if (json.is_number_unsigned() && std::in_range<T>(json.get<std::uint64_t>())) return json.get<T>();
      if (json.is_number_integer() && !json.is_number_unsigned() &&
          std::in_range<T>(json.get<std::int64_t>()))
        return json.get<T>();
      problem(where, json,
              "write a whole number from " + std::to_string(std::numeric_limits<T>::min()) + " to " +
                  std::to_string(std::numeric_limits<T>::max()));
    }
    return zero;
  }

  char character(const Json& json, const std::string& where) {
    if (json.is_null()) return 0;
    if (json.is_string()) {
      const auto& text = json.get_ref<const std::string&>();
      const auto byte = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
      if (text.size() == 1 && byte(0) < 0x80) return text[0];
      if (text.size() == 2 && (byte(0) == 0xC2 || byte(0) == 0xC3))
        return static_cast<char>((byte(0) & 0x03) << 6 | (byte(1) & 0x3F));
    }
    problem(where, json, "write a string of one Latin-1 character");
    return 0;
  }

  std::uint32_t enumerator(const Field& field, const Json& json, const std::string& where) {
    if (json.is_null()) return 0;
    const auto& names = field.enumerators;
    const auto found = json.is_string()
                           ? std::find(names.begin(), names.end(), json.get_ref<const std::string&>())
                           : names.end();
    if (found != names.end()) return static_cast<std::uint32_t>(found - names.begin());
    problem(where, json,
            suggestion(json.is_string() ? json.get<std::string>() : "", {names.begin(), names.end()}));
    return 0;
  }

  CdrWriter& to_;
  const Json missing_ = nullptr;
};

}  // namespace

bool is_sample(const Type& type, const std::byte* bytes, std::size_t size) noexcept {
  CdrReader from{bytes, size};
  check(type.fields, from);
  return from.complete();
}

std::string sample_json(const Type& type, const std::byte* bytes, std::size_t size) {
  CdrReader from{bytes, size};
  Printer printer{from};
  printer.structure(type.fields);
  return std::move(printer.text);
}

Result<std::vector<std::byte>> sample_bytes(const Type& type, const std::string& text) {
  const Json json = parse_json(text);
  if (json.is_discarded())
    return Problem{type.name, "the sample is not JSON: " + in_quotes(text), R"(write {"field": value})"};
  std::vector<std::byte> bytes(max_size(type));
  CdrWriter to{bytes.data(), bytes.size()};
  Filler filler{to};
  filler.structure(type.fields, json, type.name);
  if (!filler.problems.empty()) return std::move(filler.problems);
  bytes.resize(to.size());
  return bytes;
}

}  // namespace takt::model
