// Makes the closing report of `takt run`, which is also the output of `takt status`.
#pragma once

#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// The text of a module's state in all commands. `stopped` means: an operator stopped the module.
inline std::string state_text(const std::string& state, bool stopped) {
  return state + (stopped ? " (stopped)" : "");
}

/// The text of a module's state in all commands if the module's device is lost. `last` is the last known
/// state.
inline std::string lost_text(const std::string& last) {
  return last == "UNKNOWN" ? "LOST" : "LOST, was " + last;
}

/// The component of each module of a device's report, by module: "servo.so 1.2.0 3fa91c02".
std::map<std::string, std::string> components_in(const nlohmann::ordered_json& device);

/// Removes the file, version and hash of each module's component, because `takt run` does not report them.
void leave_out_components(nlohmann::ordered_json& status);

/// Converts a status object to tables with one line per executor and per module. With names of at most 20
/// characters, a table is at most 100 columns wide. Times are in microseconds. The text ends with a line
/// feed.
std::string run_text(const nlohmann::ordered_json& status, Style style = {});
/// Explains the columns of run_text(), for `takt status --help`.
inline constexpr const char* kColumns =
    "Times are in us. After the name of a device, `clock` is how far its clock is ahead of the clock of the\n"
    "cell's first device, and how exactly this is known. The columns of the tables:\n"
    "  jitter       release minus start, as a signed mean; p50, p99 and max are of the absolute value\n"
    "  missed       rows skipped because the row before, or the wake-up, was too late\n"
    "  margin       how long before a release the executor wakes up\n"
    "  run          how long a run takes\n"
    "  overruns     of a thread module, runs that ended after the next release or the deadline; of a\n"
    "               process module, releases at which the run before had not ended\n"
    "  matched      connections whose writer and reader have found each other, of all connections\n"
    "  lost         samples lost between writer and reader\n"
    "  dropped      samples dropped because the queue was full\n"
    "  late         how often the newest value became older than its deadline\n"
    "  now          what the connections do now; `!` marks a poor connection, and `X` a bad one. The\n"
    "               columns before cover the whole time since the deployment";
/// Converts a status object to JSON, without the margins of the executors, which only the tables show. The
/// text ends with a line feed.
std::string run_json(nlohmann::ordered_json status);

}  // namespace takt::tool
