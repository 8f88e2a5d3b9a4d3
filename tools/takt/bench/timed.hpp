// Measures operations that are too short to be timed individually.
#pragma once

#include <functional>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::bench {

/// Measures the time of each step in ns. Calls batches of the steps in turns, for about `length` in total.
/// Each result is the median of many batches, so that interruptions of some batches do not count.
std::vector<double> each_by_turns(Nanoseconds length, const std::vector<std::function<void()>>& steps);

}  // namespace takt::bench
