// Collects the values of the last hours of each port that a web page plots.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <takt/client/connection.hpp>
#include <takt/core/time.hpp>
#include <takt/recording/columns.hpp>

#include "web/stream.hpp"

namespace takt::tool::web {

/// Collects the values of a port while a page shows it, and for kUnused longer, in case the page shows it
/// again. Any thread may call the functions.
class WatchedPorts {
 public:
  static constexpr std::size_t kMost = 32;        ///< limit of the ports of one stream
  static constexpr std::size_t kMostFields = 32;  ///< limit of the plotted fields of one port
  static constexpr std::chrono::seconds kUnused{60};

  WatchedPorts(client::Connection& client, Streams& streams);
  ~WatchedPorts();

  /// Replaces the list of ports whose values a stream gets. Asks the ports' devices, which may take a few
  /// seconds. Each problem names in `where` a port whose values the stream will not get.
  Problems want(const std::shared_ptr<Stream>& stream, const std::vector<std::string>& ports);
  /// Sends to each stream the values of its ports that arrived since the last call.
  void send();
  /// Asks the devices to continue publishing the ports, and drops ports that no page shows. May take a few
  /// seconds.
  void maintain();

 private:
  struct Source;
  using Sources = std::map<std::string, std::shared_ptr<Source>>;
  Result<std::shared_ptr<Source>> source(const std::string& port);
  void resend(const std::string& port);

  client::Connection& client_;
  Streams& streams_;
  std::mutex mutex_;
  Sources sources_;
  /// For each stream id and port: the time of the last value of the port that the stream has received, in ns.
  std::map<std::string, std::map<std::string, std::int64_t>> views_;
};

}  // namespace takt::tool::web
