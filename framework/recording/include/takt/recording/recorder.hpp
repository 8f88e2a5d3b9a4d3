// Records ports of a running cell until it is told to end: behind `takt record` and the component `recorder`.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <takt/client/network.hpp>
#include <takt/recording/writer.hpp>

namespace takt::recording {

struct RecordOptions {
  std::string who = "takt record";  ///< begins what is said on standard error
  std::vector<std::string> ports;   ///< device.module.port, with * for any characters
  RecordingOptions recording;
  std::optional<double> seconds;  ///< none: until SIGINT or SIGTERM
  client::Network network;
  /// Told once a second how far it is, and with nothing before something else is said; none: nobody looks.
  std::function<void(const std::string&)> progress{};
};

/// Says on standard error which ports it records and which it waits for, and at the end what is in the file.
/// Returns the exit status: 1 when the file cannot be made, when the disk did not take everything, or when no
/// port was ever there.
int record(const RecordOptions& options);

}  // namespace takt::recording
