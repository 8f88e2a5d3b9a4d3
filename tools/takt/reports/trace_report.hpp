// Makes the output of `takt trace`, which shows which rows and modules began late, and why.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/core/result.hpp>

#include "reports/style.hpp"

namespace takt::tool {

struct TracedExecutor {
  std::string name;
  std::uint64_t rows = 0;
  std::uint64_t late = 0;     ///< the number of late rows and modules
  std::uint64_t lost = 0;     ///< the number of entries that were overwritten while the trace was read
  double holds_us = 0;        ///< how far back the executor's flight record goes
  double late_beyond_us = 0;  ///< a start with at least this delay counts as late
};

struct TracedStart {
  std::string what;  ///< the executor, or the executor and the module: "plc" or "plc.servo"
  double at_us = 0;  ///< when the start was due, since the beginning of the trace
  double late_us = 0;
  std::string cause;
  std::string why;
};

struct TraceSummary {
  std::string cell;
  std::string device;
  std::string machine;
  std::string kernel;
  std::string why;
  std::int64_t taken_utc_ns = 0;
  double lasts_us = 0;
  double left_out_us = 0;
  std::uint64_t lost = 0;
  std::vector<TracedExecutor> executors;
  std::vector<TracedStart> late;                 ///< worst first
  std::map<std::string, std::uint64_t> changes;  ///< the number of state changes of each kind
};

/// Makes the summary of a trace. Fails if `trace` is not a Takt trace.
Result<TraceSummary> summary_of(const nlohmann::ordered_json& trace);

std::string trace_report(const TraceSummary& summary, const Style& style);
nlohmann::ordered_json trace_json_report(const TraceSummary& summary);

/// Draws the runs in a trace over time, as SVG. Each executor has a lane for its rows, and each module has
/// its own lane. A late start has a mark with the reason. If there are more than kTraceBars bars, only the
/// newest are drawn, and the drawing says so. Fails if `trace` is not a Takt trace.
Result<std::string> trace_svg(const nlohmann::ordered_json& trace);
inline constexpr std::size_t kTraceBars = 4000;

}  // namespace takt::tool
