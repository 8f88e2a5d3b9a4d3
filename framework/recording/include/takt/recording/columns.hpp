// A sample as columns of a table: each number, text and enumerator that it holds has a name,
// "pose.position[0]".
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include <takt/model/type.hpp>

namespace takt::recording {

/// Of one column in one sample. Nothing: an element that its sequence does not have.
struct Value {
  std::variant<std::monostate, bool, std::int64_t, std::uint64_t, float, double, std::string> is{};
  /// Of an enumerator: its number; `is` holds its name.
  std::uint32_t enumerator = 0;

  [[nodiscard]] bool there() const { return is.index() != 0; }
  /// As a point of a curve; NaN where it is none.
  [[nodiscard]] double number(bool enumeration) const;
  /// As short as it can be read back; nothing: empty.
  [[nodiscard]] std::string text() const;
};

struct Column {
  std::string name;                        ///< "pose.position[0]"
  std::string field;                       ///< without places: "pose.position"
  bool drawable = true;                    ///< false: text
  std::vector<std::string> enumerators{};  ///< of an enumeration
};

/// Of a type, in the order of its fields; of a sequence as many elements as it may have.
class Columns {
 public:
  /// Of more columns than this the first are there.
  static constexpr std::size_t kMost = 16384;

  explicit Columns(const model::Type& type);

  [[nodiscard]] const std::vector<Column>& all() const { return columns_; }
  [[nodiscard]] bool cut() const { return cut_; }
  /// Every sample has all of them: nothing is a sequence.
  [[nodiscard]] bool fixed() const { return fixed_; }
  /// Those of this name, of the fields within it, or of its elements; all of them for an empty name.
  [[nodiscard]] std::vector<std::size_t> named(const std::string& name) const;
  /// What can be said there, each field once.
  [[nodiscard]] std::vector<std::string> fields() const;

  /// Of bytes for which is_sample() holds. `values` has then one for each column.
  void values(const std::byte* bytes, std::size_t size, std::vector<Value>& values) const;

 private:
  void name(const std::vector<model::Field>& fields, const std::string& before, const std::string& field);

  model::Type type_;
  std::vector<Column> columns_;
  bool cut_ = false;
  bool fixed_ = true;
};

}  // namespace takt::recording
