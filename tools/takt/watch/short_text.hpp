// Shortens a sample for the screen.
#pragma once

#include <string>

namespace takt::tool::watch {

/// Converts a sample in JSON to a short text: without the outer braces and the quotes around names, and with
/// numbers of at most four significant digits.
std::string short_text(const std::string& sample);

}  // namespace takt::tool::watch
