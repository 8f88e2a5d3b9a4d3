// The format of a recording: one SQLite file, which the shell of SQLite can read.
#pragma once

#include <string>

#include <takt/model/type.hpp>

namespace takt::recording {

/// The values of PRAGMA application_id ("TAKT" in ASCII) and of PRAGMA user_version (the version of these
/// tables).
inline constexpr int kRecordingId = 0x54414B54;
inline constexpr int kRecordingVersion = 2;

/// The tables. Samples are numbered without gaps in the order in which they arrived; the oldest samples may
/// have been dropped. There is no index on the time of samples: samples arrive nearly in the order of their
/// times, and the index would take a third of the space.
inline constexpr const char* kSchema = R"(
CREATE TABLE meta(name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE port(
  id INTEGER PRIMARY KEY,
  path TEXT NOT NULL,          -- device.module.port
  topic TEXT NOT NULL,         -- DDS topic of the port
  reliable INTEGER NOT NULL,   -- 1 if the writer resends lost samples
  type_name TEXT NOT NULL,     -- name of the IDL type
  type TEXT NOT NULL);         -- description of the type, as JSON
CREATE TABLE sample(
  id INTEGER PRIMARY KEY,
  port INTEGER NOT NULL REFERENCES port(id),
  time_ns INTEGER NOT NULL,    -- time of writing, since 1970 (UTC)
  missing INTEGER NOT NULL,    -- number of samples of this port that were lost before this sample
  bytes BLOB NOT NULL);        -- XCDR1 with its encapsulation
)";

/// A recorded port. If the topic, the reliability or the type of a port changes, it counts as another port.
struct RecordedPort {
  std::string path;
  std::string topic;
  bool reliable = false;
  model::Type type{};
};

}  // namespace takt::recording
