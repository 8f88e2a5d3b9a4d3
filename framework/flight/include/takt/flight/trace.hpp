// Writes a recording as a trace, in the trace format of Chrome. Perfetto (ui.perfetto.dev) and
// chrome://tracing show traces, and `takt trace` reads them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include <takt/flight/recording.hpp>

namespace takt::flight {

/// The value of `otherData.format` in a trace.
inline constexpr const char* kTraceFormat = "takt trace 1";

/// The numbers of the threads in a trace. There is one thread for the states of all modules, two for each
/// executor, and one for each process module.
constexpr std::uint32_t thread_of_states() noexcept { return 1; }
constexpr std::uint32_t thread_of_executor(std::size_t executor, std::size_t thread) noexcept {
  return static_cast<std::uint32_t>(10 + 2 * executor + thread);
}
constexpr std::uint32_t thread_of_program(std::uint32_t module) noexcept { return 100'000 + module; }

/// Returns the trace as JSON, with times in microseconds since the beginning of the trace. If the trace would
/// be longer than `most` bytes, the older part of the recording is omitted, and the trace states how much is
/// omitted.
std::string trace_json(const Recording& recording, std::size_t most);

}  // namespace takt::flight
