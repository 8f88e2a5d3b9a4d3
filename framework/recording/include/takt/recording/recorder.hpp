// Records ports of a running cell, for `takt record` and the component `recorder`.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <takt/client/network.hpp>
#include <takt/recording/writer.hpp>

namespace takt::recording {

struct RecordOptions {
  std::string who = "takt record";  ///< the beginning of each line on standard error
  std::vector<std::string> ports;   ///< names DEVICE.MODULE.PORT, in which * stands for any characters
  RecordingOptions recording;
  std::optional<double> seconds;  ///< how long to record; without a value, until SIGINT or SIGTERM
  client::Network network;
  /// Receives the progress once a second, and an empty text before any other output. An empty function is
  /// allowed.
  std::function<void(const std::string&)> progress{};
};

/// Records ports. Reports on standard error which ports it records and for which ports it waits. At the end
/// it reports the content of the file. Returns the exit status, which is 1 if the file cannot be created, if
/// not all samples could be written, or if no port ever appeared.
int record(const RecordOptions& options);

}  // namespace takt::recording
