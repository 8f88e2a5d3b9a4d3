// Measures operations that are too short to be timed individually.
#pragma once

#include <functional>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::bench {

/// Measures the time of one call of each function in `steps`, in ns. Calls a batch of each function in turn,
/// repeatedly, for about `length` in total. Each result is the median of many batches, so interruptions of a
/// few batches have no effect.
std::vector<double> each_by_turns(Nanoseconds length, const std::vector<std::function<void()>>& steps);

}  // namespace takt::bench
