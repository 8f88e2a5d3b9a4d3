// Files of a node that are there whole or not at all, whenever the power went, and that tell when a disk has
// changed them: a line with the format and a checksum, and the body.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <takt/core/result.hpp>

namespace takt::node {

Result<void> write_whole(const std::string& path, const std::string& format, const std::string& body);
/// The body; none where there is no file. Fails on one that cannot be read, has more than `most` bytes, or is
/// not as it was written: "<what> is damaged", with this fix.
Result<std::optional<std::string>> read_whole(const std::string& path, const std::string& format,
                                              std::size_t most, const Problem& damaged);

}  // namespace takt::node
