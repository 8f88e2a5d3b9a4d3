// The entries of one ring as what they were: rows with the runs in them, bodies of programs, instants.
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
  bool ended = true;  ///< false: it was in it when it was looked at, or when its host died
  [[nodiscard]] Nanoseconds took() const noexcept { return Nanoseconds{end_ns - start_ns}; }
};

struct Row {
  std::int64_t release_ns = 0;
  std::int64_t start_ns = 0;
  std::int64_t end_ns = 0;
  bool ended = true;
  std::size_t first_run = 0;  ///< of the timeline's runs
  std::size_t end_run = 0;
  [[nodiscard]] Nanoseconds late() const noexcept { return Nanoseconds{start_ns - release_ns}; }
  [[nodiscard]] Nanoseconds took() const noexcept { return Nanoseconds{end_ns - start_ns}; }
};

/// Something that takes no time: a release, a sample that was written, an event that was taken, a swap.
struct Mark {
  channel::FlightKind kind = channel::FlightKind::nothing;
  std::int64_t time_ns = 0;  ///< of what a run wrote or took: its beginning, as the sample's own time
  std::uint32_t module = 0;
  std::uint64_t value = 0;
};

struct Timeline {
  std::vector<Row> rows;
  std::vector<Run> runs;
  std::vector<Run> bodies;  ///< of programs
  std::vector<Mark> marks;
};

/// Of what began at `from_ns` or later. Entries before the first whole row are left out; of sporadic modules
/// there are runs without rows. No two rows, and no two runs, share an instant.
Timeline timeline_of(const Thread& thread, bool has_rows, std::int64_t from_ns);

}  // namespace takt::flight
