// Compresses the data of commands. A descriptor of 32 devices shrinks from 58 kB to less than 1
// kB, which is one sample instead of 57.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace takt::wire {

/// Returns the data as they are sent: as a zlib stream (RFC 1950) if they need more than one sample and the
/// stream is shorter, otherwise unchanged. The first byte of a zlib stream is 'x', so data that begin with
/// 'x' are always sent as a stream. Allocates memory.
[[nodiscard]] std::string packed(std::string data);

/// Returns the data that were packed, or nothing if they are damaged or longer than kMaxData.
[[nodiscard]] std::optional<std::string> unpacked(std::string data);

}  // namespace takt::wire
