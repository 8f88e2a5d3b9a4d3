// Converts the entries of one ring of the flight record into rows with their runs, bodies of process modules
// (a body is the work of one release), and marks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <takt/channel/flight.hpp>
#include <takt/flight/recording.hpp>

namespace takt::flight {

struct Run {
  std::uint32_t module = 0;
  std::int64_t start_ns = 0;
  std::int64_t end_ns = 0;
  bool ended = true;  ///< false if the run was in progress when its host died or the recording was made
  [[nodiscard]] Nanoseconds took() const noexcept { return Nanoseconds{end_ns - start_ns}; }
};

struct Row {
  std::int64_t release_ns = 0;
  std::int64_t start_ns = 0;
  std::int64_t end_ns = 0;
  bool ended = true;
  std::size_t first_run = 0;  ///< index of the row's first run in Timeline::runs
  std::size_t end_run = 0;
  [[nodiscard]] Nanoseconds late() const noexcept { return Nanoseconds{start_ns - release_ns}; }
  [[nodiscard]] Nanoseconds took() const noexcept { return Nanoseconds{end_ns - start_ns}; }
};

/// Something without a duration: a release, a written sample, a taken event or a swap.
struct Mark {
  channel::FlightKind kind = channel::FlightKind::nothing;
  std::int64_t time_ns = 0;  ///< for a sample or event: the beginning of the run() that wrote or took it
  std::uint32_t module = 0;
  std::uint64_t value = 0;
};

struct Timeline {
  std::vector<Row> rows;
  std::vector<Run> runs;
  std::vector<Run> bodies;  ///< the bodies of process modules
  std::vector<Mark> marks;
};

/// Returns the timeline of everything that began at `from_ns` or later. `has_rows` is true for the thread of
/// the rows; its entries before the first complete row are omitted. A sporadic thread has runs without rows.
/// Rows do not overlap, and runs do not overlap.
Timeline timeline_of(const Thread& thread, bool has_rows, std::int64_t from_ns);

}  // namespace takt::flight
