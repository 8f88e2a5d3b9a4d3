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

/// The value of one column in one sample. The value is missing if the sequence in the sample has too few
/// elements.
struct Value {
  std::variant<std::monostate, bool, std::int64_t, std::uint64_t, float, double, std::string> is{};
  /// The number of an enumerator; `is` holds its name.
  std::uint32_t enumerator = 0;

  [[nodiscard]] bool there() const { return is.index() != 0; }
  /// The value as a point of a curve; NaN if the value is not a number.
  [[nodiscard]] double number(bool enumeration) const;
  /// The shortest text from which the exact value can be read; empty if the value is missing.
  [[nodiscard]] std::string text() const;
};

struct Column {
  std::string name;                        ///< name with indices, such as "pose.position[0]"
  std::string field;                       ///< name without indices, such as "pose.position"
  bool drawable = true;                    ///< false for text
  std::string unit{};                      ///< may be empty
  std::vector<std::string> enumerators{};  ///< only for enumerations
};

/// The columns of a type, in the order of its fields. A sequence has one column for each element that it may
/// have.
class Columns {
 public:
  /// The largest number of columns; further columns are omitted.
  static constexpr std::size_t kMost = 16384;

  explicit Columns(const model::Type& type);

  [[nodiscard]] const std::vector<Column>& all() const { return columns_; }
  [[nodiscard]] bool cut() const { return cut_; }
  /// True if every sample has values for all columns, because the type contains no sequence.
  [[nodiscard]] bool fixed() const { return fixed_; }
  /// Returns the indices of the columns of this field, of its subfields and of its elements. If `name` is
  /// empty, returns the indices of all columns.
  [[nodiscard]] std::vector<std::size_t> named(const std::string& name) const;
  /// All field names that named() accepts.
  [[nodiscard]] std::vector<std::string> fields() const;

  /// Decodes a sample into `values`, with one value per column. The bytes must have passed is_sample().
  void values(const std::byte* bytes, std::size_t size, std::vector<Value>& values) const;

 private:
  void name(const std::vector<model::Field>& fields, const std::string& before, const std::string& field);

  model::Type type_;
  std::vector<Column> columns_;
  bool cut_ = false;
  bool fixed_ = true;
};

}  // namespace takt::recording
