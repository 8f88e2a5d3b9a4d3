// Runs the cases of the paper's Table 1, each in its own node and host, as `takt run` does.
#pragma once

#include <functional>

#include <takt/core/result.hpp>

#include "settings.hpp"
#include "table1_result.hpp"

namespace takt::bench {

/// A function that run_table1() calls before the first case and after each case. The last case in the result
/// is the newest.
using Table1Progress = std::function<void(const Table1Result&)>;

/// Runs all ten cases. Each case, with its bare loop, takes about 2 x settings.seconds plus 2 s. Call this
/// function only while the process has no other threads.
Result<Table1Result> run_table1(const Settings& settings, const Table1Progress& progress);

}  // namespace takt::bench
