// Writes files so that after a power failure they have either the old or the new content, and detects damaged
// files when it reads them. A file consists of one line with its format and a checksum, followed by the body.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <takt/core/result.hpp>

namespace takt::node {

Result<void> write_whole(const std::string& path, const std::string& format, const std::string& body);
/// Returns the body of a file, or nothing if there is no file. Fails if other users can replace the file
/// (os::check_writers()), if it cannot be read, if it has more than `most` bytes, or if it was damaged after it
/// was written. For a damaged file, the result is the problem `damaged` with the reason added.
Result<std::optional<std::string>> read_whole(const std::string& path, const std::string& format,
                                              std::size_t most, const Problem& damaged);

}  // namespace takt::node
