// Runs the cases of Table 1, each in nodes and hosts of its own, as `takt run` does.
#pragma once

#include <functional>

#include <takt/core/result.hpp>

#include "settings.hpp"
#include "table1_result.hpp"

namespace takt::bench {

/// Told before the first case, and after each; the last of the cases is the new one.
using Table1Progress = std::function<void(const Table1Result&)>;

/// All ten; with the bare loop about 2 x settings.seconds and 2 s each. Not where there are other threads.
Result<Table1Result> run_table1(const Settings& settings, const Table1Progress& progress);

}  // namespace takt::bench
