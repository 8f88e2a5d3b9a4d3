// An XML document as values: elements, their attributes and texts, each with its line.
//
// tinyxml2's own tree belongs to one document and knows one file. Ours can be copied, changed and put
// together of several files: that is how includes and templates become a cell.
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
  std::string value;  ///< entities resolved
  model::Line line{};
};

struct Text {
  std::string text;  ///< as written, entities resolved; not of white space alone
  model::Line line{};
};

/// An element.
struct Node {
  std::string name;
  model::Line line{};
  std::vector<Attribute> attributes{};
  std::vector<Node> children{};
  std::vector<Text> texts{};
  bool incomplete = false;  ///< more was to stand in it, and could not be made; that was reported

  [[nodiscard]] const Attribute* attribute(std::string_view wanted) const;
  [[nodiscard]] Attribute* attribute(std::string_view wanted);
  [[nodiscard]] const Node* child(std::string_view wanted) const;
  [[nodiscard]] Node* child(std::string_view wanted);
  /// All of its texts, one after the other.
  [[nodiscard]] std::string text() const;
};

/// The root of the document, its lines in the insertion. A fault, and no root, where it cannot be read.
std::optional<Fault> read_tree(std::string_view xml, std::uint32_t insertion, Node& root);

/// The text without white space around it.
std::string trimmed(std::string_view text);

}  // namespace takt::descriptor
