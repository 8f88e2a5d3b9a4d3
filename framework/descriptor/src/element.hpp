// Reads one element of a descriptor, and reports everything in it that is not allowed.
//
// A reader that only looks for known names would not notice a misspelled name: with <perod>, a module would
// have no period or, worse, a default one. So an Element first checks that its shape allows each attribute,
// child and text. Only then are the values read.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <takt/model/cell.hpp>
#include "report.hpp"
#include "tree.hpp"

namespace takt::descriptor {

/// The attributes, children and text that an element is allowed to have.
struct Shape {
  std::vector<std::string_view> attributes{};
  std::vector<std::string_view> once{};  ///< names of the children that may appear at most once
  std::vector<std::string_view> many{};  ///< names of the children that may appear any number of times
  bool text = false;                     ///< true if the element may have text
  /// Pairs of a value and an attribute. If an attribute with an unknown name has this value, the author meant
  /// this attribute.
  std::vector<std::pair<std::string_view, std::string_view>> telling{};
  std::string_view hint{};  ///< what to write instead of an attribute or a text that the element cannot have
};

/// The text of an attribute or element, with the name that messages use for it.
struct Given {
  std::string what;  ///< the attribute or element as messages call it, for example "<period>" or "attribute
                     ///< 'cpu'"
  std::string text;  ///< the text as written, with entities resolved
  model::Line line{};
  /// True if the element contains child elements. The children were already reported, so no value is read
  /// from the text.
  bool unread = false;

  /// Returns the text without leading and trailing white space.
  [[nodiscard]] std::string trimmed() const { return descriptor::trimmed(text); }
};

/// An element of the tree, which is checked against its shape. The tree must outlive this object.
class Element {
 public:
  /// Checks the element against the shape, and reports everything that the shape does not allow.
  Element(const Node& node, Shape shape, Report& report);

  [[nodiscard]] model::Line line() const { return node_.line; }
  [[nodiscard]] std::string text() const { return node_.text(); }
  /// Returns the text of the element with the element's name and line, so that a value can be read from it.
  [[nodiscard]] Given given_text() const;

  [[nodiscard]] std::optional<Given> attribute(const char* name) const;
  /// Returns the attribute with this name. Reports the attribute if it is missing.
  [[nodiscard]] std::optional<Given> required_attribute(const char* name) const;

  [[nodiscard]] std::vector<const Node*> children(std::string_view name) const;
  /// Returns the first child with this name; null if there is none.
  [[nodiscard]] const Node* child(const char* name) const { return node_.child(name); }
  /// Returns the text of the child with this name. Reports everything in the child except text.
  [[nodiscard]] std::optional<Given> child_text(const char* name) const;

  /// Returns true if an unknown attribute or child is probably a misspelled `name`. Then the caller should
  /// not also report `name` as missing.
  [[nodiscard]] bool was_meant(std::string_view name) const;
  /// Returns true if the element has children that are unknown or could not be created.
  [[nodiscard]] bool has_unknown_children() const { return unknown_children_ || node_.incomplete; }

 private:
  void check_attributes();
  void check_children();
  [[nodiscard]] std::string hint() const;
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

/// Returns the decimal whole number in a text, without exponent or '+' ('-' is allowed if the range includes
/// negative numbers). Reports any other text and any number outside the range. `unit` completes the message,
/// for example " of percent".
std::optional<std::int64_t> read_number(const Given& given, Range range, Report& report,
                                        const char* unit = "");

struct TimeRange {
  Nanoseconds from{0};
  Nanoseconds to = Nanoseconds::max();
};

/// Returns the time in a text: a whole number of nanoseconds, or a number with the unit ns, us, ms or s, such
/// as "500us" or "1.5 ms". Reports any other text and any time outside the range.
std::optional<Nanoseconds> read_time(const Given& given, TimeRange range, Report& report);

/// Returns the index of the word in `choices`. Reports a word that `choices` does not contain.
std::optional<std::size_t> read_choice(const Given& given, const std::vector<std::string_view>& choices,
                                       Report& report);

/// Reads an overrun contract from its name and its limit. Only catch-up may have a limit.
model::OverrunContract read_contract(const Given& word, const std::optional<Given>& limit, Report& report);

}  // namespace takt::descriptor
