// The number that identifies a DDS writer.
#pragma once

#include <cstdint>

namespace takt::wire {

/// Identifies a DDS writer on the network. A number is valid as long as this process runs.
using WriterId = std::uint64_t;

}  // namespace takt::wire
