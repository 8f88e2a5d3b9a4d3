// The number of a writer of states.
#pragma once

#include <cstdint>

namespace takt::wire {

/// Identifies a writer on the network during the life of this process.
using WriterId = std::uint64_t;

}  // namespace takt::wire
