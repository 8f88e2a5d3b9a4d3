// The benchmarks but Table 1. Each measures for about as long as it says, or settings.seconds of each
// measurement, by turns with what it is compared to. They fail only where they cannot measure at all;
// `refused` gets what the system does not grant. Not where there are other threads.
#pragma once

#include <takt/core/result.hpp>

#include "report.hpp"
#include "settings.hpp"

namespace takt::bench {

/// What it costs a module to be called from a table: N in a row, and 1000 at 1 ms beside a thread for each.
Result<std::vector<Section>> dispatch(const Settings& settings, Problems& refused);
/// How punctual a wake-up is by each strategy of an executor, beside the bare loop.
Result<std::vector<Section>> wake(const Settings& settings, Problems& refused);
/// From release to the body of a process module, beside a signal and a futex.
Result<std::vector<Section>> process(const Settings& settings, Problems& refused);
/// What a sample of 64 bytes costs from port to port, beside memcpy.
Result<std::vector<Section>> ports(const Settings& settings, Problems& refused);
/// How long a cell of several devices takes to be deployed, and a sample from one to another, beside DDS
/// alone.
Result<std::vector<Section>> cell(const Settings& settings, Problems& refused);

}  // namespace takt::bench
