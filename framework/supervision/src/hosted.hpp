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

/// A fault for which the node kills a host: a call that did not return, or an executor that runs no rows.
struct Hang {
  std::optional<std::uint32_t> module{};  ///< the module that was called; empty if an executor runs no rows
  channel::Doing doing = channel::Doing::nothing;
  Nanoseconds limit{};
  std::string text{};
  std::int32_t thread = 0;  ///< the thread that called the module
  Instant found{};          ///< when the node found the hang

  static Hang of_call(std::uint32_t module, const channel::Activity& activity, Nanoseconds limit,
                      Instant now) {
    const channel::Doing doing = activity.doing.load();
    return {module,
            doing,
            limit,
            std::string{channel::to_text(doing)} + " did not return within " + to_text(limit),
            activity.thread.load(),
            now};
  }
};

struct Hosted {
  Hosted(model::HostShare s, std::size_t i, channel::HostBlock& b, std::unique_ptr<Host> p)
      : share(std::move(s)), index(i), block(b), process(std::move(p)) {}

  const model::HostShare share;
  const std::size_t index;  ///< index of `share` in model::hosts_of()
  channel::HostBlock& block;
  std::unique_ptr<Host> process;
  bool begun = false;                     ///< true if the executors of the present process run rows
  bool halted = false;                    ///< true if the executors of the host have ended
  bool killed = false;                    ///< true if the node killed the host because it did not halt
  std::optional<Hang> hung;               ///< the hang for which the node killed the host
  std::optional<Instant> silent_since{};  ///< since when a request is open although the host calls no hook
  std::vector<Instant> restarts{};  ///< times of the restarts after which no module was found to be at fault

  /// "the host", or "the host of executor motion"
  [[nodiscard]] std::string name() const {
    return share.is_own() ? "the host of executor " + share.name : "the host";
  }
};

}  // namespace takt::supervision
