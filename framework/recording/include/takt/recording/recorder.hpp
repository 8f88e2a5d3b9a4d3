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
  std::string who = "takt record";  ///< begins each line on standard error
  std::vector<std::string> ports;   ///< device.module.port, where * stands for any characters
  RecordingOptions recording;
  std::optional<double> seconds;  ///< none: until SIGINT or SIGTERM
  client::Network network;
  /// Receives the progress once a second, and an empty text before any other output. May be empty.
  std::function<void(const std::string&)> progress{};
};

/// Reports on standard error which ports it records and for which it waits, and at the end the content of the
/// file. Returns the exit status: 1 if the file cannot be created, if the disk did not take everything, or if
/// no port ever appeared.
int record(const RecordOptions& options);

}  // namespace takt::recording
