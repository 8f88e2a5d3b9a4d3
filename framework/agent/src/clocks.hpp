// How far the clocks of two devices differ, and the text that says so.
#pragma once

#include <string>

#include <takt/agent/clock_offset.hpp>

namespace takt::agent {

/// True if the clocks certainly differ by more than kClocksDiffer. `ahead`: bounds on the wall clock of
/// another device minus the wall clock of this device.
bool differ(const ClockBounds& ahead) noexcept;

/// Returns how far the clock of `own` is ahead of or behind the clock of `other`, the limit, and what to do.
std::string difference_text(const std::string& own, const std::string& other, const ClockBounds& ahead);

}  // namespace takt::agent
