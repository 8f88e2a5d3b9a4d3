// Comma-separated values, as RFC 4180 says.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace takt::recording {

/// In quotes where it holds a comma, a quote or an end of line.
std::string csv_field(std::string_view text);
/// With the end of the line, CR LF.
std::string csv_line(const std::vector<std::string>& fields);

}  // namespace takt::recording
