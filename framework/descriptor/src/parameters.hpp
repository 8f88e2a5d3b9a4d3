// Replaces references to the parameters of a template: ${NAME} in a value becomes the value of the parameter
// NAME, and $${ becomes a literal ${.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "tree.hpp"

namespace takt::descriptor {

/// Returns the value of a parameter; null if the name is unknown.
using Meaning = std::function<const std::string*(std::string_view name)>;
/// Called for a reference that cannot be replaced. `name` is the name in the reference, or none if the } is
/// missing.
using Unknown = std::function<void(std::optional<std::string_view> name)>;

/// The text with its references replaced. Unknown references are removed. Inserted values are not searched
/// for further references.
std::string substituted(std::string_view text, const Meaning& meaning, const Unknown& unknown);

/// Replaces the references in every attribute and text of a node and of its descendants. `unknown` also gets
/// the line.
void substitute(Node& node, const Meaning& meaning,
                const std::function<void(model::Line line, std::optional<std::string_view> name)>& unknown);

}  // namespace takt::descriptor
