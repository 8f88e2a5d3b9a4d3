// Converts bytes to hexadecimal text and back. Not for real-time threads: both functions allocate.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace takt {

/// Two lower-case digits per byte: "00ff".
std::string in_hex(std::span<const std::byte> bytes);
/// Accepts digits in upper and lower case. None if the text has an odd length or contains any other
/// character.
std::optional<std::vector<std::byte>> bytes_of_hex(std::string_view text);

}  // namespace takt
