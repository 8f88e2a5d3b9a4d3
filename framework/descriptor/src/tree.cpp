#include "tree.hpp"

#include <algorithm>

#include <tinyxml2.h>

namespace takt::descriptor {

namespace {

/// Converts an element and, recursively, its children. The recursion is limited, because the scanner has
/// rejected elements deeper than kMaxDepth.
Node node_of(const tinyxml2::XMLElement& xml, std::uint32_t insertion) {
  Node node{.name = xml.Name(), .line = {xml.GetLineNum(), insertion}};
  for (const auto* one = xml.FirstAttribute(); one != nullptr; one = one->Next())
    node.attributes.push_back({one->Name(), one->Value(), {one->GetLineNum(), insertion}});
  bool continued = false;  // A text remains one text even if a comment or a CDATA section splits it.
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

std::optional<Fault> read_tree(std::string_view xml, std::uint32_t insertion, Node& root) {
  if (auto fault = find_fault(xml)) return fault;
  tinyxml2::XMLDocument document;
  document.Parse(xml.data(), xml.size());
  if (document.Error() || document.RootElement() == nullptr) {
    return Fault{document.ErrorLineNum(),
                 std::string{"the XML cannot be read ("} + document.ErrorName() + ")",
                 "check the tags, quotes and entities of this line"};
  }
  root = node_of(*document.RootElement(), insertion);
  return std::nullopt;
}

std::string trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return std::string{text.substr(first, text.find_last_not_of(kBlanks) - first + 1)};
}

}  // namespace takt::descriptor
