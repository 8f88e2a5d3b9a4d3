// Checks that a text is well-formed XML before tinyxml2 parses it.
//
// tinyxml2 accepts much that XML forbids: unknown entities, repeated attributes, attributes of a closing tag,
// text after the root element, other encodings. It guesses what such text means, but the meaning of a
// descriptor must be certain. So this scanner checks the whole text first, and tinyxml2 receives only text
// that has a single meaning.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace takt::descriptor {

struct Fault {
  int line = 1;
  std::string what;
  std::string fix;
};

/// The maximum nesting depth of elements; the limit of tinyxml2 is 100.
inline constexpr std::size_t kMaxDepth = 50;
/// The maximum number of tags, attributes, comments and texts. Without this limit, a text of many small tags
/// could occupy a hundred times its size in memory.
inline constexpr std::size_t kMaxParts = 1'000'000;

/// Returns the first fault; the meaning of the text after it is uncertain. A text without a fault is UTF-8
/// without control characters. It has one root element and at most kMaxParts parts. It has no document type,
/// no processing instruction except the XML declaration, and no entities except the five that XML defines.
std::optional<Fault> find_fault(std::string_view xml);

}  // namespace takt::descriptor
