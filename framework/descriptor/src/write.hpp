// A tree as XML.
#pragma once

#include <string>

#include "tree.hpp"

namespace takt::descriptor {

/// Reads back as the same tree, without white space between elements. A comment before each element that an
/// insertion begins with says where that comes from. ${ is written $${, as it was.
std::string written(const Node& root, const model::Texts& texts);

/// The text, with what means something in XML as references; read back it is the same.
std::string escaped(std::string_view text);

}  // namespace takt::descriptor
