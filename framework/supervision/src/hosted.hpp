// A host process under supervision.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <takt/channel/layout.hpp>
#include <takt/core/time.hpp>
#include <takt/model/hosts.hpp>
#include <takt/supervision/platform.hpp>

namespace takt::supervision {

/// A call that did not return within its limit.
struct Hang {
  std::uint32_t module;
  channel::Doing doing;
  Nanoseconds limit;
};

struct Hosted {
  Hosted(model::HostShare s, std::size_t i, channel::HostBlock& b, std::unique_ptr<Host> p)
      : share(std::move(s)), index(i), block(b), process(std::move(p)) {}

  const model::HostShare share;
  const std::size_t index;  ///< in model::hosts_of()
  channel::HostBlock& block;
  std::unique_ptr<Host> process;
  bool halted = false;              ///< its executors have ended
  std::optional<Hang> hung;         ///< the hang for which the node killed the host
  std::vector<Instant> restarts{};  ///< times of the restarts for which no module was found to be at fault

  /// "the host", or "the host of executor motion"
  [[nodiscard]] std::string name() const {
    return share.is_own() ? "the host of executor " + share.name : "the host";
  }
};

}  // namespace takt::supervision
