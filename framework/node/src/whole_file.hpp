// Writes files so that a power failure leaves the old or the new content, and checks for damage when it reads
// them. A file consists of one line with the format and a checksum, followed by the body.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <takt/core/result.hpp>

namespace takt::node {

Result<void> write_whole(const std::string& path, const std::string& format, const std::string& body);
/// Returns the body of a file, or nothing if there is no file. Fails if the file cannot be read, has more
/// than `most` bytes, or has been damaged since it was written. If it is damaged, the problem is `damaged`
/// with the reason added.
Result<std::optional<std::string>> read_whole(const std::string& path, const std::string& format,
                                              std::size_t most, const Problem& damaged);

}  // namespace takt::node
