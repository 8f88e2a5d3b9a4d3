#include "timeline.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

namespace takt::flight {

namespace {

using channel::FlightKind;
using channel::FlightSample;

class Reader {
 public:
  Reader(const Thread& thread, bool has_rows, std::int64_t from_ns)
      : thread_(thread), has_rows_(has_rows), from_ns_(from_ns) {}

  Timeline read() {
    for (const FlightSample& entry : thread_.copy.entries) {
      if (entry.kind == FlightKind::row) close_row(entry.time_ns);
      // Skip entries until the first row that began at `from_ns_` or later, because the row before it is
      // incomplete.
      if (entry.time_ns < from_ns_ || (has_rows_ && !in_row_ && entry.kind != FlightKind::row)) continue;
      take(entry);
    }
    close_row(std::nullopt);
    if (!has_rows_) add_open(0, std::nullopt);
    return std::move(line_);
  }

 private:
  void take(const FlightSample& entry) {
    switch (entry.kind) {
      case FlightKind::row:
        in_row_ = true;
        pending_.clear();
        line_.rows.push_back({.release_ns = entry.time_ns - static_cast<std::int64_t>(entry.value),
                              .start_ns = entry.time_ns,
                              .end_ns = entry.time_ns,
                              .ended = false,
                              .first_run = line_.runs.size(),
                              .end_run = line_.runs.size()});
        break;
      case FlightKind::run:
        add_run({entry.module, entry.time_ns - static_cast<std::int64_t>(entry.value), entry.time_ns});
        break;
      case FlightKind::row_end:
        line_.rows.back().end_ns = entry.time_ns;
        line_.rows.back().ended = true;
        line_.rows.back().end_run = line_.runs.size();
        in_row_ = false;
        break;
      case FlightKind::body: {
        const Run body{entry.module, entry.time_ns - static_cast<std::int64_t>(entry.value), entry.time_ns};
        std::int64_t& before_ns = bodies_end_[entry.module];
        if (body.end_ns <= before_ns) break;  // the restarted host has recorded this body again
        before_ns = body.end_ns;
        line_.bodies.push_back(body);
        break;
      }
      case FlightKind::released:
      case FlightKind::ready:
      case FlightKind::swapped:
        line_.marks.push_back({entry.kind, entry.time_ns, entry.module, entry.value});
        break;
      case FlightKind::write:
      case FlightKind::event:
        pending_.push_back({entry.kind, entry.time_ns, entry.module, entry.value});
        break;
      case FlightKind::nothing:
        break;
    }
  }

  void add_run(const Run& run) {
    if (run.start_ns < from_ns_) {
      pending_.clear();
      return;
    }
    line_.runs.push_back(run);
    for (Mark& mark : pending_) {
      mark.time_ns = run.start_ns;
      line_.marks.push_back(mark);
    }
    pending_.clear();
  }

  // Closes the present row if it has no entry for its end, because its host died in the row or the row is
  // still running. `next_ns` is the beginning of the next row, if there is one.
  void close_row(std::optional<std::int64_t> next_ns) {
    if (!in_row_) return;
    in_row_ = false;
    Row& row = line_.rows.back();
    if (line_.runs.size() > row.first_run) row.end_ns = line_.runs.back().end_ns;
    add_open(row.end_ns, next_ns);
    row.end_run = line_.runs.size();
    if (row.end_run > row.first_run) row.end_ns = std::max(row.end_ns, line_.runs.back().end_ns);
  }

  // Adds the run that was in progress when its host died or the recording was made, if this run began after
  // `after_ns` and was observed before `next_ns`.
  void add_open(std::int64_t after_ns, std::optional<std::int64_t> next_ns) {
    if (!line_.runs.empty()) after_ns = std::max(after_ns, line_.runs.back().end_ns);
    for (const Open& open : thread_.open) {
      if (open.doing != channel::Doing::run || open.since_ns < after_ns || open.seen_ns < open.since_ns)
        continue;
      if (next_ns && open.seen_ns > *next_ns) continue;
      Run run{open.module, open.since_ns, open.seen_ns};
      run.ended = false;
      add_run(run);
      if (has_rows_) return;
    }
  }

  const Thread& thread_;
  bool has_rows_;
  std::int64_t from_ns_;
  bool in_row_ = false;
  std::vector<Mark> pending_;
  std::map<std::uint32_t, std::int64_t> bodies_end_;  // for each process module, the end of its last body
  Timeline line_;
};

}  // namespace

Timeline timeline_of(const Thread& thread, bool has_rows, std::int64_t from_ns) {
  return Reader{thread, has_rows, from_ns}.read();
}

}  // namespace takt::flight
