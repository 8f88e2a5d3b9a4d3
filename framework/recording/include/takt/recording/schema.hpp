// The format of a recording: one SQLite file, which the shell of SQLite can read.
#pragma once

#include <string>

#include <takt/model/type.hpp>

namespace takt::recording {

/// PRAGMA application_id: "TAKT". PRAGMA user_version: the version of these tables.
inline constexpr int kRecordingId = 0x54414B54;
inline constexpr int kRecordingVersion = 1;

/// Samples are numbered in the order in which they came, without gaps; the oldest may be missing. There is no
/// index on their time, which would cost a third of the space: samples arrive nearly in that order.
inline constexpr const char* kSchema = R"(
CREATE TABLE meta(name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE port(
  id INTEGER PRIMARY KEY,
  path TEXT NOT NULL,          -- device.module.port
  topic TEXT NOT NULL,         -- on which it was heard
  reliable INTEGER NOT NULL,   -- whether the writer sends again what was lost
  type_name TEXT NOT NULL,     -- of IDL
  type TEXT NOT NULL);         -- its description, as JSON
CREATE TABLE sample(
  id INTEGER PRIMARY KEY,
  port INTEGER NOT NULL REFERENCES port(id),
  time_ns INTEGER NOT NULL,    -- when it was written, since 1970 (UTC)
  bytes BLOB NOT NULL);        -- XCDR1 with its encapsulation
)";

/// A recorded port. If its type changes, it counts as another port.
struct RecordedPort {
  std::string path;
  std::string topic;
  bool reliable = false;
  model::Type type{};
};

}  // namespace takt::recording
