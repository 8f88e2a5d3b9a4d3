// Checks that a text is well-formed XML before tinyxml2 parses it.
//
// tinyxml2 accepts many texts that XML forbids: unknown entities, repeated attributes, attributes of a
// closing tag, text after the root element, other encodings. It guesses what such a text means, but the
// meaning of a descriptor must be certain. So the scanner in this file checks the whole text first, and
// tinyxml2 receives only texts that have a single meaning.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace takt::descriptor {

struct SyntaxError {
  int line = 1;
  std::string what;
  std::string fix;
};

/// The maximum nesting depth of elements; the limit of tinyxml2 is 100.
inline constexpr std::size_t kMaxDepth = 50;
/// The maximum number of tags, attributes, comments and texts. Without this limit, a text of many small tags
/// could occupy a hundred times its size in memory.
inline constexpr std::size_t kMaxParts = 1'000'000;

/// A range of bytes in the text.
struct Span {
  std::size_t begin = 0;
  std::size_t size = 0;
};

/// Returns the first error; none if the text is well-formed. The meaning of the text after an error is
/// uncertain, so only one error is returned. A text without an error is UTF-8 without control characters. It
/// has one root element and at most kMaxParts parts. It has no document type, no processing instruction
/// except the XML declaration and <?xml-model?>, and no entities except the five that XML defines. If
/// `models` is not null, the ranges of all <?xml-model?> instructions are added to it.
std::optional<SyntaxError> find_syntax_error(std::string_view xml, std::vector<Span>* models = nullptr);

}  // namespace takt::descriptor
