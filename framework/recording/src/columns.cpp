#include <takt/recording/columns.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <functional>
#include <limits>
#include <type_traits>

#include <takt/core/cdr.hpp>

namespace takt::recording {

namespace {

using model::Field;
using model::Scalar;

std::size_t product(const std::vector<std::size_t>& dimensions) {
  std::size_t result = 1;
  for (const std::size_t n : dimensions) result *= n;
  return result;
}

std::size_t width(const std::vector<Field>& fields);

/// The number of columns of one value.
std::size_t single(const Field& field) { return field.scalar == Scalar::structure ? width(field.fields) : 1; }

/// The number of columns of one value, or of one sequence if the field is a sequence.
std::size_t span(const Field& field) {
  return field.sequence == 0 ? single(field) : field.sequence * product(field.elements) * single(field);
}

std::size_t width(const std::vector<Field>& fields) {
  std::size_t all = 0;
  for (const Field& field : fields) all += product(field.dimensions) * span(field);
  return all;
}

/// Decodes a sample into the values of the columns.
class Reading {
 public:
  Reading(CdrReader from, std::vector<Value>& values) : from_(from), values_(values) {}

  void structure(const std::vector<Field>& fields, std::size_t at) {
    for (const Field& field : fields) {
      const std::size_t one = single(field);
      const std::size_t each = span(field);
      const std::size_t n = product(field.dimensions);
      for (std::size_t i = 0; i < n; ++i, at += each) {
        if (field.sequence == 0) {
          value(field, at);
          continue;
        }
        const std::size_t length = from_.get_length(field.sequence) * product(field.elements);
        for (std::size_t k = 0; k < length; ++k) value(field, at + k * one);
      }
    }
  }

 private:
  template <class T>
  void put(std::size_t at, T value, std::uint32_t enumerator = 0) {
    if (at < values_.size()) values_[at] = {std::move(value), enumerator};
  }
  template <class T, class As>
  void number(std::size_t at) {
    put(at, static_cast<As>(from_.get<T>()));
  }
  void value(const Field& field, std::size_t at) {
    switch (field.scalar) {
      case Scalar::boolean:
        return put(at, from_.get_boolean());
      case Scalar::octet:
        return number<std::uint8_t, std::uint64_t>(at);
      case Scalar::character:
        return put(at, std::string(1, from_.get<char>()));
      case Scalar::int8:
        return number<std::int8_t, std::int64_t>(at);
      case Scalar::int16:
        return number<std::int16_t, std::int64_t>(at);
      case Scalar::uint16:
        return number<std::uint16_t, std::uint64_t>(at);
      case Scalar::int32:
        return number<std::int32_t, std::int64_t>(at);
      case Scalar::uint32:
        return number<std::uint32_t, std::uint64_t>(at);
      case Scalar::int64:
        return number<std::int64_t, std::int64_t>(at);
      case Scalar::uint64:
        return number<std::uint64_t, std::uint64_t>(at);
      case Scalar::float32:
        return number<float, float>(at);
      case Scalar::float64:
        return number<double, double>(at);
      case Scalar::text:
        return put(at, std::string{from_.get_text(field.bound)});
      case Scalar::enumeration: {
        const std::uint32_t number =
            from_.get_enumerator(static_cast<std::uint32_t>(field.enumerators.size()));
        return put(at, field.enumerators.at(number), number);
      }
      case Scalar::structure:
        return structure(field.fields, at);
    }
  }

  CdrReader from_;
  std::vector<Value>& values_;
};

}  // namespace

double Value::number(bool enumeration) const {
  if (enumeration && there()) return enumerator;
  return std::visit(
      [](const auto& value) -> double {
        if constexpr (std::is_arithmetic_v<std::decay_t<decltype(value)>>)
          return static_cast<double>(value);
        else
          return std::numeric_limits<double>::quiet_NaN();
      },
      is);
}

std::string Value::text() const {
  return std::visit(
      [](const auto& value) -> std::string {
        using T = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<T, std::monostate>) {
          return "";
        } else if constexpr (std::is_same_v<T, bool>) {
          return value ? "true" : "false";
        } else if constexpr (std::is_same_v<T, std::string>) {
          return value;
        } else {
          std::array<char, 32> digits{};
          return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
        }
      },
      is);
}

Columns::Columns(const model::Type& type) : type_(type) { name(type_.fields, "", ""); }

void Columns::name(const std::vector<Field>& fields, const std::string& before, const std::string& field) {
  for (const Field& each : fields) {
    const std::string dot = before.empty() ? "" : ".";
    const std::string whole = field + dot + each.name;
    fixed_ = fixed_ && each.sequence == 0;
    const std::function<void(const std::vector<std::size_t>&, std::size_t, const std::string&,
                             const std::function<void(const std::string&)>&)>
        places = [&](const std::vector<std::size_t>& dimensions, std::size_t from, const std::string& text,
                     const std::function<void(const std::string&)>& then) {
          if (from == dimensions.size()) return then(text);
          for (std::size_t i = 0; i < dimensions[from] && !cut_; ++i)
            places(dimensions, from + 1, text + '[' + std::to_string(i) + ']', then);
        };
    const auto value = [&](const std::string& text) {
      if (each.scalar == Scalar::structure) return name(each.fields, text, whole);
      if (columns_.size() == kMost) {
        cut_ = true;
        return;
      }
      columns_.push_back({text, whole, each.scalar != Scalar::text && each.scalar != Scalar::character,
                          each.unit, each.enumerators});
    };
    places(each.dimensions, 0, before + dot + each.name, [&](const std::string& text) {
      if (each.sequence == 0) return value(text);
      for (std::size_t i = 0; i < each.sequence && !cut_; ++i)
        places(each.elements, 0, text + '[' + std::to_string(i) + ']', value);
    });
  }
}

std::vector<std::size_t> Columns::named(const std::string& name) const {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const std::string& column = columns_[i].name;
    const bool within = column.size() > name.size() && column.compare(0, name.size(), name) == 0 &&
                        (column[name.size()] == '.' || column[name.size()] == '[');
    if (name.empty() || column == name || within || columns_[i].field == name) found.push_back(i);
  }
  return found;
}

std::vector<std::string> Columns::fields() const {
  std::vector<std::string> fields;
  for (const Column& column : columns_) {
    if (std::find(fields.begin(), fields.end(), column.field) == fields.end()) fields.push_back(column.field);
  }
  return fields;
}

void Columns::values(const std::byte* bytes, std::size_t size, std::vector<Value>& values) const {
  values.assign(columns_.size(), {});
  Reading{CdrReader{bytes, size}, values}.structure(type_.fields, 0);
}

}  // namespace takt::recording
