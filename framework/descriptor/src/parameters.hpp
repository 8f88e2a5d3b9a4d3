// ${NAME} in a value stands for a parameter of a template, $${ for ${ itself.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "tree.hpp"

namespace takt::descriptor {

/// What a name stands for; null where nobody knows it.
using Meaning = std::function<const std::string*(std::string_view name)>;
/// Is told of a reference that stands for nothing: its name, or none where it has no }.
using Unknown = std::function<void(std::optional<std::string_view> name)>;

/// The text with what its references stand for. What stands for nothing is left out. What is put in is not
/// looked at again.
std::string substituted(std::string_view text, const Meaning& meaning, const Unknown& unknown);

/// The same for every attribute and text of a node and of what is in it. `unknown` gets the line too.
void substitute(Node& node, const Meaning& meaning,
                const std::function<void(model::Line line, std::optional<std::string_view> name)>& unknown);

}  // namespace takt::descriptor
