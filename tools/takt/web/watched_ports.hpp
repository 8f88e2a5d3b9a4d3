// Collects the values of the ports that pages plot, over the last minutes.
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

/// Any thread may call its functions. The values of a port are collected while a page shows the port, and for
/// kUnused longer, in case the page returns.
class WatchedPorts {
 public:
  static constexpr std::size_t kMost = 8;                 ///< ports of one stream
  static constexpr std::size_t kMostFields = 32;          ///< fields of a port that are kept
  static constexpr std::chrono::minutes kKept{5};         ///< how long values are kept
  static constexpr std::chrono::milliseconds kApart{20};  ///< minimum distance of values; others are dropped
  static constexpr std::chrono::seconds kUnused{60};

  WatchedPorts(client::Connection& client, Streams& streams);
  ~WatchedPorts();

  /// Replaces the ports whose values the stream gets. Asks their devices, which may take a few seconds. A
  /// problem names its port in `where`; the other ports are not affected.
  Problems want(const std::shared_ptr<Stream>& stream, const std::vector<std::string>& ports);
  /// Sends the values that have arrived since the last call.
  void send();
  /// Asks devices to continue publishing, and drops ports that no page shows. May take a few seconds.
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
  /// For each stream: how many values of each port it has got.
  std::map<std::string, std::map<std::string, std::uint64_t>> views_;
};

}  // namespace takt::tool::web
