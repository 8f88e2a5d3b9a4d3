// Collects the values of the last hours of each port that a web page plots, and the newest value of each port
// that a web page shows.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <takt/client/connection.hpp>
#include <takt/core/time.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/recording/columns.hpp>

#include "web/stream.hpp"

namespace takt::tool::web {

/// Collects the values of a port while a page shows it, and for kKept longer, in case a page shows it again.
/// Asks the devices for every sample of a port only while a page plots the port, and for kUnplotted longer.
/// Any thread may call the functions.
class WatchedPorts {
 public:
  static constexpr std::size_t kMost = 32;         ///< limit of the plotted ports of one stream
  static constexpr std::size_t kMostNewest = 500;  ///< limit of the ports whose newest value one stream gets
  /// Time between two newest values of a port. People cannot read values that change faster.
  static constexpr std::chrono::milliseconds kNewestEvery{500};
  static constexpr std::size_t kMostFields = 32;  ///< limit of the plotted fields of one port
  static constexpr std::chrono::seconds kUnplotted{60};
  /// Age of the oldest value of a port that no page plots. A plot of it then begins with these values.
  static constexpr std::chrono::minutes kKept{10};

  WatchedPorts(client::Connection& client, Streams& streams);
  ~WatchedPorts();

  using Ports = std::optional<std::vector<std::string>>;
  /// Replaces the lists of ports of which a stream gets all values and only the newest value. A list that is
  /// not given stays. The stream gets all values of the ports that were not on its list, and of those in
  /// `again`. Asks the ports' devices, which may take a few seconds. Each problem names in `where` a port
  /// whose values the stream will not get.
  Problems want(const std::shared_ptr<Stream>& stream, const Ports& plotted, const Ports& newest,
                const Ports& again);
  /// Sends to each stream the values of its ports that arrived since the last call, and each newest value
  /// that differs from the one that the stream has.
  void send();
  /// Asks the devices to continue publishing the ports, and drops ports that no page shows. May take a few
  /// seconds.
  void maintain();

 private:
  struct Source;
  using Sources = std::map<std::string, std::shared_ptr<Source>>;
  struct View {
    std::map<std::string, std::int64_t>
        plotted;  // by port: the time of the last value that the stream has, in ns
    std::map<std::string, std::string> newest;  // by port: the newest value that the stream has
  };
  std::map<std::string, Problems> ask(const std::map<std::string, bool>& ports);
  Result<void> keep(const std::string& port, dds::Flow flow, bool whole);
  void send_newest(Stream& stream, View& view);

  client::Connection& client_;
  Streams& streams_;
  std::mutex mutex_;
  Sources sources_;
  std::map<std::string, View> views_;  // by the id of the stream
  Instant newest_sent_{};
};

}  // namespace takt::tool::web
