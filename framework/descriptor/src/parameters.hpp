// Replaces references to the parameters of a template: ${NAME} becomes the value of the parameter NAME, and
// $${ becomes a literal ${.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "tree.hpp"

namespace takt::descriptor {

/// A function that returns the value of a parameter; null if there is no parameter with this name.
using Meaning = std::function<const std::string*(std::string_view name)>;
/// A function that is called for each reference that cannot be replaced. `name` is the name in the reference;
/// it is none if the closing } is missing.
using Unknown = std::function<void(std::optional<std::string_view> name)>;

/// Returns the text with all references replaced. Removes references to unknown parameters, and calls
/// `unknown` for each. References inside the inserted values are not replaced.
std::string substituted(std::string_view text, const Meaning& meaning, const Unknown& unknown);

/// Replaces the references in every attribute and text of a node and of its descendants. Calls `unknown` for
/// each reference that cannot be replaced, with the line of the reference and the name in it (none if the
/// closing } is missing).
void substitute(Node& node, const Meaning& meaning,
                const std::function<void(model::Line line, std::optional<std::string_view> name)>& unknown);

}  // namespace takt::descriptor
