// How long something takes that is too short to be timed once.
#pragma once

#include <functional>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::bench {

/// The nanoseconds that each of the steps takes, called over and over by turns for about `length` in all: the
/// median of many batches, so that what interrupts some of them does not count.
std::vector<double> each_by_turns(Nanoseconds length, const std::vector<std::function<void()>>& steps);

}  // namespace takt::bench
