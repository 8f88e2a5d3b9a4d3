// The output of `takt trace`: which rows and modules were late, and why.
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
  std::uint64_t late = 0;     ///< late rows and modules
  std::uint64_t lost = 0;     ///< entries that were overwritten while they were read
  double holds_us = 0;        ///< how far back its flight record goes
  double late_beyond_us = 0;  ///< a start counts as late from this delay on
};

struct TracedStart {
  std::string what;  ///< "plc" or "plc.servo"
  double at_us = 0;  ///< when it was due, from the beginning of the trace
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
  std::map<std::string, std::uint64_t> changes;  ///< the number of state changes, by their name
};

/// Summarises a trace. Fails if `trace` is not a Takt trace.
Result<TraceSummary> summary_of(const nlohmann::ordered_json& trace);

std::string trace_report(const TraceSummary& summary, const Style& style);
nlohmann::ordered_json trace_json_report(const TraceSummary& summary);

/// What ran when, as SVG: a lane for the rows of each executor, for each module and each program. A mark,
/// with the reason, shows what began late. If there are more than kTraceBars bars, only the newest are drawn,
/// and the drawing says so. Fails like summary_of().
Result<std::string> trace_svg(const nlohmann::ordered_json& trace);
inline constexpr std::size_t kTraceBars = 4000;

}  // namespace takt::tool
