// A recording as a file that people look at: in the trace format of Chrome, which Perfetto (ui.perfetto.dev)
// and chrome://tracing show, and `takt trace` reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include <takt/flight/recording.hpp>

namespace takt::flight {

/// What `otherData.format` says.
inline constexpr const char* kTraceFormat = "takt trace 1";

/// The threads of a trace: two of each executor, one of each program, one for the states of modules.
constexpr std::uint32_t thread_of_states() noexcept { return 1; }
constexpr std::uint32_t thread_of_executor(std::size_t executor, std::size_t thread) noexcept {
  return static_cast<std::uint32_t>(10 + 2 * executor + thread);
}
constexpr std::uint32_t thread_of_program(std::uint32_t module) noexcept { return 100'000 + module; }

/// As JSON, times in microseconds since the recording's beginning. Of one that would be longer than `most`
/// bytes the older part is left out, and it says so.
std::string trace_json(const Recording& recording, std::size_t most);

}  // namespace takt::flight
