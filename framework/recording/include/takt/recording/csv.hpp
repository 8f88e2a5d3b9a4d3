// Comma-separated values according to RFC 4180.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace takt::recording {

/// Returns the text, in quotes if it contains a comma, a quote or a line break.
std::string csv_field(std::string_view text);
/// Returns the fields as a line that ends with CR LF.
std::string csv_line(const std::vector<std::string>& fields);

}  // namespace takt::recording
