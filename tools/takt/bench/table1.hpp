// Runs the cases of Table 1, each in its own nodes and hosts, as `takt run` does.
#pragma once

#include <functional>

#include <takt/core/result.hpp>

#include "settings.hpp"
#include "table1_result.hpp"

namespace takt::bench {

/// Called before the first case and after each case. The last case of the result is the new one.
using Table1Progress = std::function<void(const Table1Result&)>;

/// Runs all ten cases. With the bare loop, each takes about 2 x settings.seconds plus 2 s. Call it only while
/// the process has no other threads.
Result<Table1Result> run_table1(const Settings& settings, const Table1Progress& progress);

}  // namespace takt::bench
