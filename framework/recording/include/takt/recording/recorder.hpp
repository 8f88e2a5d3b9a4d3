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
  std::string who = "takt record";  ///< text at the beginning of each line on standard error
  std::vector<std::string> ports;   ///< names of the form DEVICE.MODULE.PORT, in which * stands for any
                                    ///< characters
  RecordingOptions recording;
  std::optional<double> seconds;  ///< duration of the recording, in s; without a value, record() ends at
                                  ///< SIGINT or SIGTERM
  client::Network network;
  /// Called once a second with a text about the progress, and with an empty text before any other output.
  /// This function may be empty.
  std::function<void(const std::string&)> progress{};
};

/// Records ports. Reports on standard error which ports it records, and for which ports it waits. At the end,
/// reports the content of the file. Returns the exit status, which is 1 if the file cannot be created, if not
/// all samples could be written, or if no port was recorded.
int record(const RecordOptions& options);

}  // namespace takt::recording
