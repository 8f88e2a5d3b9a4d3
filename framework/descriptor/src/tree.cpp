#include "tree.hpp"

#include <algorithm>

#include <tinyxml2.h>

namespace takt::descriptor {

namespace {

/// Converts an element and, recursively, its children. The depth of the recursion is limited, because the
/// scanner has rejected elements deeper than kMaxDepth.
Node node_of(const tinyxml2::XMLElement& xml, std::uint32_t insertion) {
  Node node{.name = xml.Name(), .line = {xml.GetLineNum(), insertion}};
  for (const auto* one = xml.FirstAttribute(); one != nullptr; one = one->Next())
    node.attributes.push_back({one->Name(), one->Value(), {one->GetLineNum(), insertion}});
  // True if the next text continues the last one, because a comment or CDATA section split the text into
  // parts.
  bool continued = false;
  for (const auto* one = xml.FirstChild(); one != nullptr; one = one->NextSibling()) {
    if (const auto* element = one->ToElement()) {
      node.children.push_back(node_of(*element, insertion));
      continued = false;
    } else if (const auto* text = one->ToText()) {
      if (continued)
        node.texts.back().text += text->Value();
      else
        node.texts.push_back({text->Value(), {text->GetLineNum(), insertion}});
      continued = true;
    }
  }
  return node;
}

constexpr const char* kDeclaration = "xmlns:xsi";
constexpr const char* kInstances = "http://www.w3.org/2001/XMLSchema-instance";
constexpr const char* kSchema = "xsi:noNamespaceSchemaLocation";

/// Removes the attributes of the root element that tell editors where the schema is. Takt does not open the
/// schema.
std::optional<SyntaxError> remove_schema(Node& root) {
  const std::string right = std::string{"write "} + kDeclaration + "=\"" + kInstances + "\"";
  const Attribute* declared = root.attribute(kDeclaration);
  if (declared != nullptr && declared->value != kInstances)
    return SyntaxError{declared->line.number, std::string{"wrong value of "} + kDeclaration, right};
  const Attribute* schema = root.attribute(kSchema);
  if (schema != nullptr && declared == nullptr)
    return SyntaxError{schema->line.number, std::string{kSchema} + " without " + kDeclaration, right};
  std::erase_if(root.attributes,
                [](const Attribute& one) { return one.name == kDeclaration || one.name == kSchema; });
  return std::nullopt;
}

template <class Named>
Named* find(std::vector<Named>& all, std::string_view wanted) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Named& one) { return one.name == wanted; });
  return found == all.end() ? nullptr : &*found;
}
template <class Named>
const Named* find(const std::vector<Named>& all, std::string_view wanted) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Named& one) { return one.name == wanted; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace

const Attribute* Node::attribute(std::string_view wanted) const { return find(attributes, wanted); }
Attribute* Node::attribute(std::string_view wanted) { return find(attributes, wanted); }
const Node* Node::child(std::string_view wanted) const { return find(children, wanted); }
Node* Node::child(std::string_view wanted) { return find(children, wanted); }

std::string Node::text() const {
  std::string all;
  for (const Text& one : texts) all += one.text;
  return all;
}

std::optional<SyntaxError> read_tree(std::string_view xml, std::uint32_t insertion, Node& root) {
  std::vector<Span> models;
  if (auto error = find_syntax_error(xml, &models)) return error;
  // <?xml-model?> is blanked, because tinyxml2 allows <?...?> only before the first comment.
  std::string blanked{xml};
  for (const Span& model : models) {
    for (std::size_t i = 0; i < model.size; ++i) {
      char& c = blanked[model.begin + i];
      if (c != '\n') c = ' ';
    }
  }
  tinyxml2::XMLDocument document;
  document.Parse(blanked.data(), blanked.size());
  if (document.Error() || document.RootElement() == nullptr) {
    return SyntaxError{document.ErrorLineNum(),
                       std::string{"the XML cannot be read ("} + document.ErrorName() + ")",
                       "check the tags, quotes and entities of this line"};
  }
  root = node_of(*document.RootElement(), insertion);
  return remove_schema(root);
}

std::string trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return std::string{text.substr(first, text.find_last_not_of(kBlanks) - first + 1)};
}

}  // namespace takt::descriptor
