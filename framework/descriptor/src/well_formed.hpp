// Checks that a text is well-formed XML before tinyxml2 parses it.
//
// tinyxml2 accepts much that XML forbids: unknown entities, repeated attributes, attributes of a closing tag,
// text after the root, foreign encodings. It would guess the meaning, but the meaning of a descriptor must
// not be guessed. So this scanner checks the whole text first, and tinyxml2 gets only text with one possible
// reading.
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

/// The maximum nesting of elements; that of tinyxml2 is 100.
inline constexpr std::size_t kMaxDepth = 50;
/// The maximum number of tags, attributes, comments and texts. Without it, a text of many small tags could
/// take a hundred times its size in memory.
inline constexpr std::size_t kMaxParts = 1'000'000;

/// Returns the first fault; text after it has no certain meaning. A text without a fault is UTF-8 without
/// control characters. It has one root element, at most kMaxParts parts, no document type, no processing
/// instruction except the XML declaration, and no entities except the five of XML.
std::optional<Fault> find_fault(std::string_view xml);

}  // namespace takt::descriptor
