// From what is heard of a domain to what the screen of `takt watch` shows.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/client/history.hpp>
#include <takt/core/time.hpp>
#include <takt/dds/picture.hpp>
#include <takt/model/cell.hpp>

#include "watch/seen.hpp"

namespace takt::tool {

/// What has to be kept between two screens. One thread.
class Watched {
 public:
  explicit Watched(int domain) : domain_(domain) {}

  /// Of every transition, in order.
  void hear(const LifecycleStatus& status);
  /// A line about what happened.
  void hear(const std::string& event);
  /// The descriptor that runs; null: the node that was asked did not say.
  void hear(const std::string& deployment, std::shared_ptr<const model::Cell> cell);

  /// A device that is to be asked for its descriptor now: it counts as asked.
  struct Unknown {
    std::string device;
    std::string deployment;
  };
  std::optional<Unknown> unknown(const std::vector<dds::SeenDevice>& devices, Instant now);

  /// Everything, as it is now.
  watch::Seen seen(const std::vector<dds::SeenDevice>& devices);

 private:
  int domain_;
  client::History history_;
  std::map<std::string, std::vector<watch::Transition>> transitions_;  // by DEVICE.MODULE
  std::deque<std::string> events_;
  struct Known {
    std::shared_ptr<const model::Cell> cell;
    Instant asked{};
  };
  std::map<std::string, Known> cells_;  // by deployment
};

/// "12:34:56.789" in local time.
std::string clock_text(std::int64_t wall_ns);

}  // namespace takt::tool
