// Bytes as text. Not for real-time threads: both allocate.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace takt {

/// Two digits a byte: "00ff".
std::string in_hex(std::span<const std::byte> bytes);
/// None where the text is no such one.
std::optional<std::vector<std::byte>> bytes_of_hex(std::string_view text);

}  // namespace takt
