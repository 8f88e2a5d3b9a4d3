// Shows a sample as columns of a table. Each number, text and enumerator has a name such as
// "pose.position[0]".
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include <takt/model/type.hpp>

namespace takt::recording {

/// The value of one column in one sample. It is missing if the sequence is too short for it.
struct Value {
  std::variant<std::monostate, bool, std::int64_t, std::uint64_t, float, double, std::string> is{};
  /// For an enumerator its number; `is` holds its name.
  std::uint32_t enumerator = 0;

  [[nodiscard]] bool there() const { return is.index() != 0; }
  /// The value for a curve; NaN if it is not a number.
  [[nodiscard]] double number(bool enumeration) const;
  /// The shortest text that can be read back; empty if the value is missing.
  [[nodiscard]] std::string text() const;
};

struct Column {
  std::string name;                        ///< "pose.position[0]"
  std::string field;                       ///< without indices: "pose.position"
  bool drawable = true;                    ///< false for text
  std::vector<std::string> enumerators{};  ///< only for enumerations
};

/// The columns of a type, in the order of its fields. A sequence has as many columns as it may have elements.
class Columns {
 public:
  /// The most columns; further ones are omitted.
  static constexpr std::size_t kMost = 16384;

  explicit Columns(const model::Type& type);

  [[nodiscard]] const std::vector<Column>& all() const { return columns_; }
  [[nodiscard]] bool cut() const { return cut_; }
  /// Whether every sample has all columns, because the type has no sequence.
  [[nodiscard]] bool fixed() const { return fixed_; }
  /// The columns of this name, of its subfields, or of its elements; all columns for an empty name.
  [[nodiscard]] std::vector<std::size_t> named(const std::string& name) const;
  /// The valid field names for named(), each once.
  [[nodiscard]] std::vector<std::string> fields() const;

  /// Decodes bytes for which is_sample() holds. Afterwards `values` has one value per column.
  void values(const std::byte* bytes, std::size_t size, std::vector<Value>& values) const;

 private:
  void name(const std::vector<model::Field>& fields, const std::string& before, const std::string& field);

  model::Type type_;
  std::vector<Column> columns_;
  bool cut_ = false;
  bool fixed_ = true;
};

}  // namespace takt::recording
