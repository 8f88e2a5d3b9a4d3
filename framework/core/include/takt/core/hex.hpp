// Converts bytes to hexadecimal text and back. Not for real-time threads, because both functions allocate
// memory.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace takt {

/// Converts each byte to two lower-case digits, for example "00ff".
std::string in_hex(std::span<const std::byte> bytes);
/// Converts hexadecimal digits, in upper or lower case, to bytes. Returns std::nullopt if the text has an odd
/// length or contains a character that is not a hexadecimal digit.
std::optional<std::vector<std::byte>> bytes_of_hex(std::string_view text);

}  // namespace takt
