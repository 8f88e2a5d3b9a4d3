// The values of ports that somebody looks at, over the last minutes.
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

/// Any thread. A port is asked for while somebody looks at it, and kept a minute longer, for whoever comes
/// back.
class WatchedPorts {
 public:
  static constexpr std::size_t kMost = 8;         ///< that one stream looks at
  static constexpr std::size_t kMostFields = 32;  ///< of a port that are kept
  static constexpr std::chrono::minutes kKept{5};
  static constexpr std::chrono::milliseconds kApart{20};  ///< values; those between are left out
  static constexpr std::chrono::seconds kUnused{60};

  WatchedPorts(client::Connection& client, Streams& streams);
  ~WatchedPorts();

  /// The stream is told of these ports from now on, and of no other. Asks their devices, which may take a few
  /// seconds. Problems name their port in `where`; the others are told of.
  Problems want(const std::shared_ptr<Stream>& stream, const std::vector<std::string>& ports);
  /// Sends what came since the last time.
  void tell();
  /// Asks devices to go on publishing, and forgets what nobody looks at. May take a few seconds.
  void look_after();

 private:
  struct Source;
  using Sources = std::map<std::string, std::shared_ptr<Source>>;
  Result<std::shared_ptr<Source>> source(const std::string& port);
  void show_anew(const std::string& port);

  client::Connection& client_;
  Streams& streams_;
  std::mutex mutex_;
  Sources sources_;
  /// Of each stream: how much it has of each port.
  std::map<std::string, std::map<std::string, std::uint64_t>> views_;
};

}  // namespace takt::tool::web
