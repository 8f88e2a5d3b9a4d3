// Writes an element tree as XML.
#pragma once

#include <string>

#include "tree.hpp"

namespace takt::descriptor {

/// Returns the tree as XML. Reading this XML gives the same tree, apart from white space between elements.
/// Before the first element of each insertion, a comment names the file and line of the insertion. ${ is
/// written as $${.
std::string written(const Node& root, const model::Texts& texts);

/// Returns the text with XML's special characters replaced by references, so that a parser reads the original
/// text.
std::string escaped(std::string_view text);

}  // namespace takt::descriptor
