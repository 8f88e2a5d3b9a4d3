// The benchmarks other than Table 1. Each benchmark measures in turns with its reference, for its default
// time or for settings.seconds per measurement. A benchmark fails only if it cannot measure at all. `refused`
// gets the requests that the system denies. Call these functions only while the process has no other threads.
#pragma once

#include <takt/core/result.hpp>

#include "report.hpp"
#include "settings.hpp"

namespace takt::bench {

/// Measures what it costs to call a module from a table: N modules in a row, and 1000 modules at 1 ms against
/// 1000 threads.
Result<std::vector<Section>> dispatch(const Settings& settings, Problems& refused);
/// Measures how punctual the wake-up of an executor is, for each strategy, against the bare loop.
Result<std::vector<Section>> wake(const Settings& settings, Problems& refused);
/// Measures the time from the release of a process module to its body, against a signal and a futex.
Result<std::vector<Section>> process(const Settings& settings, Problems& refused);
/// Measures what it costs to transfer a sample of 64 bytes from port to port, against memcpy.
Result<std::vector<Section>> ports(const Settings& settings, Problems& refused);
/// Measures how long it takes to deploy a cell of several devices and to transfer a sample between devices,
/// against DDS alone.
Result<std::vector<Section>> cell(const Settings& settings, Problems& refused);

}  // namespace takt::bench
