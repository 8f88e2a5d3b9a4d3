// An XML document as plain values: elements with their attributes and texts, each with its source line.
//
// A tree of tinyxml2 belongs to one document and one file. A tree of Nodes can be copied, changed and
// assembled from several files, as includes and templates require.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <takt/model/line.hpp>
#include "well_formed.hpp"

namespace takt::descriptor {

struct Attribute {
  std::string name;
  std::string value;  ///< the value with its entities resolved
  model::Line line{};
};

struct Text {
  std::string text;  ///< the text as written, with its entities resolved; never only white space
  model::Line line{};
};

/// An element with its attributes, texts and children.
struct Node {
  std::string name;
  model::Line line{};
  std::vector<Attribute> attributes{};
  std::vector<Node> children{};
  std::vector<Text> texts{};
  /// True if some of the element's content could not be created. The reason was reported.
  bool incomplete = false;

  [[nodiscard]] const Attribute* attribute(std::string_view wanted) const;
  [[nodiscard]] Attribute* attribute(std::string_view wanted);
  [[nodiscard]] const Node* child(std::string_view wanted) const;
  [[nodiscard]] Node* child(std::string_view wanted);
  /// Returns all texts of the element, joined together.
  [[nodiscard]] std::string text() const;
};

/// Parses a document, and sets `root` to its root element. All lines in the tree belong to `insertion`. If
/// the document cannot be parsed, returns the error and does not change `root`.
std::optional<SyntaxError> read_tree(std::string_view xml, std::uint32_t insertion, Node& root);

/// Returns the text without leading and trailing white space.
std::string trimmed(std::string_view text);

}  // namespace takt::descriptor
