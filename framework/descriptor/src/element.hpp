// Reads one element and reports everything in it that is not allowed.
//
// A reader that only looks for the names that it knows would not notice a misspelled name: with <perod>, a
// module would have no period or, worse, a default one. So an Element first checks that its shape allows each
// attribute, child and text. Only then are its values read.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <takt/model/cell.hpp>
#include "report.hpp"
#include "tree.hpp"

namespace takt::descriptor {

/// The attributes, children and text that an element is allowed to have.
struct Shape {
  std::vector<std::string_view> attributes{};
  std::vector<std::string_view> once{};  ///< children that may appear at most once
  std::vector<std::string_view> many{};  ///< children that may appear any number of times
  bool text = false;                     ///< true if the element may have text
};

/// The text of an attribute or element, with a name for messages.
struct Given {
  std::string what;  ///< name for messages, for example "<period>" or "attribute 'cpu'"
  std::string text;  ///< as written, with entities resolved
  model::Line line{};
  bool unread = false;  ///< true if the element contains child elements; these were reported, so no value is
                        ///< read from it

  /// The text without leading and trailing white space.
  [[nodiscard]] std::string trimmed() const { return descriptor::trimmed(text); }
};

/// An element of the tree. The tree must outlive this object.
class Element {
 public:
  /// Checks the element against the shape, and reports everything that the shape does not allow.
  Element(const Node& node, Shape shape, Report& report);

  [[nodiscard]] model::Line line() const { return node_.line; }
  [[nodiscard]] std::string text() const { return node_.text(); }
  /// The text of the element with its name and line, from which a value can be read.
  [[nodiscard]] Given given_text() const;

  [[nodiscard]] std::optional<Given> attribute(const char* name) const;
  /// Like attribute(), but reports the attribute if it is missing.
  [[nodiscard]] std::optional<Given> required_attribute(const char* name) const;

  [[nodiscard]] std::vector<const Node*> children(std::string_view name) const;
  /// The first child with this name, or null.
  [[nodiscard]] const Node* child(const char* name) const { return node_.child(name); }
  /// The text of a child. Reports everything in the child except text.
  [[nodiscard]] std::optional<Given> child_text(const char* name) const;

  /// Returns true if an unknown attribute or child is probably a misspelled `name`. Then `name` must not be
  /// reported as missing, too.
  [[nodiscard]] bool was_meant(std::string_view name) const;
  /// Returns true if the element has children that are unknown or could not be created.
  [[nodiscard]] bool has_unknown_children() const { return unknown_children_ || node_.incomplete; }

 private:
  void check_attributes();
  void check_children();
  void reject_child(const Node& child);

  const Node& node_;
  Shape shape_;
  Report& report_;
  std::vector<std::string_view> meant_;
  bool unknown_children_ = false;
};

struct Range {
  std::int64_t from = 0;
  std::int64_t to = std::numeric_limits<std::int64_t>::max();
};

/// Reads a decimal whole number, without exponent or '+' ('-' is allowed if the range includes negative
/// numbers). Reports any other text. `unit` completes the message, for example " of nanoseconds".
std::optional<std::int64_t> read_number(const Given& given, Range range, const char* unit, Report& report);

/// Returns the index of the word in `choices`. Reports a word that is not one of them.
std::optional<std::size_t> read_choice(const Given& given, const std::vector<std::string_view>& choices,
                                       Report& report);

/// Reads an overrun contract from its name and its limit. Only catch-up may have a limit.
model::OverrunContract read_contract(const Given& word, const std::optional<Given>& limit, Report& report);

}  // namespace takt::descriptor
