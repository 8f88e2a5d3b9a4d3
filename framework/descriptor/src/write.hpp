// Writes a tree as XML.
#pragma once

#include <string>

#include "tree.hpp"

namespace takt::descriptor {

/// The tree as XML that reads back as the same tree, apart from white space between elements. A comment
/// before the first element of each insertion names its source. ${ is written as $${.
std::string written(const Node& root, const model::Texts& texts);

/// The text with XML's special characters as references, so that it reads back unchanged.
std::string escaped(std::string_view text);

}  // namespace takt::descriptor
