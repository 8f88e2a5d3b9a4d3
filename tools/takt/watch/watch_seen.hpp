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
#include <takt/dds/cell_state.hpp>
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
  std::optional<Unknown> unknown(const std::vector<dds::ObservedDevice>& devices, Instant now);

  /// Everything, as it is now. A device of a cell that was lost before anybody looked is heard of no more; it
  /// is shown as lost where it is not found within kFound.
  watch::Seen seen(const std::vector<dds::ObservedDevice>& devices, Instant now);
  static constexpr std::chrono::seconds kFound{2};

 private:
  struct Known;
  static void add_missed(watch::Seen& seen, Known& known, const std::vector<dds::ObservedDevice>& devices,
                         Instant now);

  int domain_;
  client::History history_;
  std::map<std::string, std::vector<watch::Transition>> transitions_;  // by DEVICE.MODULE
  std::deque<std::string> events_;
  struct Known {
    std::shared_ptr<const model::Cell> cell;
    Instant asked{};
    std::map<std::string, Instant> missed{};  ///< devices of it that are not there, since when
  };
  std::map<std::string, Known> cells_;  // by deployment
};

}  // namespace takt::tool
