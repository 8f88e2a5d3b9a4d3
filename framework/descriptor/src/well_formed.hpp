// What XML says of a file before anybody asks what it means.
//
// tinyxml2 reads on over much that XML forbids: entities that do not exist, a second value of an attribute,
// attributes of a closing tag, text after the root, encodings it does not know. It would guess, and a
// descriptor is never guessed at. So the whole file is walked here first, and tinyxml2 gets only what can be
// read in one way.
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

/// Elements in elements; tinyxml2 goes no deeper than 100.
inline constexpr std::size_t kMaxDepth = 50;
/// Tags, attributes, comments and texts together, so that a text that is all tags cannot take a hundred times
/// its size in memory.
inline constexpr std::size_t kMaxParts = 1'000'000;

/// The first fault; nothing after it has a sure meaning. None means: UTF-8 without control characters, one
/// root element, not more than kMaxParts, no document type, no processing instruction but the XML
/// declaration, no entity but the five of XML.
std::optional<Fault> find_fault(std::string_view xml);

}  // namespace takt::descriptor
