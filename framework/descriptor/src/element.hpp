// Reads one element so that nothing of it goes unread.
//
// Asking an XML tree for what one knows leaves what one does not know unseen: <perod> is then a module
// without a period, or worse, one with a default. So an element is first held against its shape, which
// accounts for each attribute, child and text; only then it is asked for values.
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

/// What an element may hold.
struct Shape {
  std::vector<std::string_view> attributes{};
  std::vector<std::string_view> once{};  ///< children that stand at most once
  std::vector<std::string_view> many{};  ///< children that stand any number of times
  bool text = false;
};

/// The text of an attribute or of an element, with what to call it in a message.
struct Given {
  std::string what;  ///< "<period>", "attribute cpu"
  std::string text;  ///< as written, entities resolved
  model::Line line{};
  bool unread = false;  ///< there is more in it than text, which was reported: no value is taken from it

  [[nodiscard]] std::string trimmed() const {
    return descriptor::trimmed(text);
  }  ///< without white space around it
};

/// An element of the tree, which must outlive it.
class Element {
 public:
  /// Reports everything that the shape does not allow.
  Element(const Node& node, Shape shape, Report& report);

  [[nodiscard]] model::Line line() const { return node_.line; }
  [[nodiscard]] std::string text() const { return node_.text(); }
  /// The same, to be read as a value.
  [[nodiscard]] Given given_text() const;

  [[nodiscard]] std::optional<Given> attribute(const char* name) const;
  /// As attribute(), and reports one that is not there.
  [[nodiscard]] std::optional<Given> required_attribute(const char* name) const;

  [[nodiscard]] std::vector<const Node*> children(std::string_view name) const;
  /// The first of this name, or null.
  [[nodiscard]] const Node* child(const char* name) const { return node_.child(name); }
  /// The text of a child that holds text only.
  [[nodiscard]] std::optional<Given> child_text(const char* name) const;

  /// Something unknown stands here that was most likely meant to be `name`; that `name` is missing is then no
  /// news.
  [[nodiscard]] bool was_meant(std::string_view name) const;
  /// There are children that were not understood, or could not be made.
  [[nodiscard]] bool has_unknown_children() const { return unknown_children_ || node_.incomplete; }

 private:
  void check_attributes();
  void check_children();
  void refuse_child(const Node& child);

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

/// A decimal number without fraction, exponent or sign (a '-' where the range has negative numbers). Reports
/// what is none.
std::optional<std::int64_t> read_number(const Given& given, Range range, const char* unit, Report& report);

/// The index of the word among the choices. Reports a word that is none of them.
std::optional<std::size_t> read_choice(const Given& given, const std::vector<std::string_view>& choices,
                                       Report& report);

/// An overrun contract: its word, and the limit that only catch-up has.
model::OverrunContract read_contract(const Given& word, const std::optional<Given>& limit, Report& report);

}  // namespace takt::descriptor
