// The benchmarks other than Table 1. Each benchmark measures Takt and a reference alternately. Each
// measurement takes settings.seconds or, if that is not set, the benchmark's default time. A benchmark fails
// only if it cannot measure at all. Each function adds to `refused` each request that the system denied. Call
// the functions only while the process has no other threads.
#pragma once

#include <takt/core/result.hpp>

#include "report.hpp"
#include "settings.hpp"

namespace takt::bench {

/// Measures the cost of calling modules from a table: N modules in one row, and 1000 modules at 1 ms compared
/// with 1000 threads.
Result<std::vector<Section>> dispatch(const Settings& settings, Problems& refused);
/// Measures how punctually an executor wakes up, with each wake-up strategy, compared with the bare loop.
Result<std::vector<Section>> wake(const Settings& settings, Problems& refused);
/// Measures the time from the release of a process module to the start of its body, compared with waking
/// another process by a signal and by a futex.
Result<std::vector<Section>> process(const Settings& settings, Problems& refused);
/// Measures the cost of transferring a sample of 64 bytes from one port to another, compared with memcpy.
Result<std::vector<Section>> ports(const Settings& settings, Problems& refused);
/// Measures the time to deploy a cell of several devices and, compared with DDS without Takt, the time to
/// transfer a sample between devices.
Result<std::vector<Section>> cell(const Settings& settings, Problems& refused);

}  // namespace takt::bench
