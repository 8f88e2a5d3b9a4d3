// Reads one element and reports everything in it that is not allowed.
//
// A reader that only looks up the names that it knows would not see a misspelled name: with <perod>, a module
// would have no period, or worse, a default one. So an Element first compares each attribute, child and text
// with the shape of the element. Only then are values read from it.
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

/// The attributes, children and text that an element may have.
struct Shape {
  std::vector<std::string_view> attributes{};
  std::vector<std::string_view> once{};  ///< children that may appear at most once
  std::vector<std::string_view> many{};  ///< children that may appear any number of times
  bool text = false;                     ///< whether the element may have text
};

/// The text of an attribute or of an element, and its name for messages.
struct Given {
  std::string what;  ///< "<period>", "attribute cpu"
  std::string text;  ///< as written, entities resolved
  model::Line line{};
  bool unread = false;  ///< it contains elements, which were reported, so no value is read from it

  /// The text without surrounding white space.
  [[nodiscard]] std::string trimmed() const { return descriptor::trimmed(text); }
};

/// An element of the tree; the tree must outlive it.
class Element {
 public:
  /// Reports everything that the shape does not allow.
  Element(const Node& node, Shape shape, Report& report);

  [[nodiscard]] model::Line line() const { return node_.line; }
  [[nodiscard]] std::string text() const { return node_.text(); }
  /// The text with its name and line, to be read as a value.
  [[nodiscard]] Given given_text() const;

  [[nodiscard]] std::optional<Given> attribute(const char* name) const;
  /// Like attribute(), but reports a missing attribute.
  [[nodiscard]] std::optional<Given> required_attribute(const char* name) const;

  [[nodiscard]] std::vector<const Node*> children(std::string_view name) const;
  /// The first child of this name, or null.
  [[nodiscard]] const Node* child(const char* name) const { return node_.child(name); }
  /// The text of a child that may contain only text.
  [[nodiscard]] std::optional<Given> child_text(const char* name) const;

  /// Whether an unknown attribute or child is most likely a misspelled `name`. Then a missing `name` is not
  /// reported again.
  [[nodiscard]] bool was_meant(std::string_view name) const;
  /// Whether the element has children that are unknown or could not be created.
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

/// Reads a decimal number without fraction, exponent or sign ('-' is allowed if the range has negative
/// numbers). Reports anything else. `unit` is for the message: " of nanoseconds".
std::optional<std::int64_t> read_number(const Given& given, Range range, const char* unit, Report& report);

/// The index of the word in `choices`. Reports a word that is not one of the choices.
std::optional<std::size_t> read_choice(const Given& given, const std::vector<std::string_view>& choices,
                                       Report& report);

/// Reads an overrun contract from its word and its limit; only catch-up has a limit.
model::OverrunContract read_contract(const Given& word, const std::optional<Given>& limit, Report& report);

}  // namespace takt::descriptor
