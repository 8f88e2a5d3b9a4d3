// The inputs of modules that operators force: they read a given value instead of the samples of the connected
// output, for a limited time.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/supervision/parts.hpp>
#include <takt/supervision/supervised.hpp>
#include "fault_notes.hpp"

namespace takt::supervision {

struct Member;

class Forces {
 public:
  /// All references must outlive this object. `log` prints a line about a module.
  Forces(Parts& parts, const std::vector<std::unique_ptr<Member>>& members, const FaultNotes& notes,
         std::function<void(const Member&, const std::string&)> log)
      : parts_(parts), members_(members), notes_(notes), log_(std::move(log)) {}

  /// Begins or renews a force; see Supervised::force().
  Result<std::string> force(const Member& member, const ForceRequest& request, Instant now);
  /// Ends a force, because `who` asked for it.
  Result<void> end(const Member& member, const std::string& port, const std::string& who);
  /// Ends all forces of a module. `why` follows the words "is no longer forced: ".
  void end_all(const Member& member, const std::string& why);
  /// Ends the forces whose time is over, that were not renewed, or whose module does not execute.
  void check(Instant now);

  /// Who forces the input; empty if it is not forced.
  [[nodiscard]] std::string by(const Member& member, const std::string& port) const;
  /// The force of an input, for the report; null if the input is not forced.
  [[nodiscard]] nlohmann::ordered_json report(const Member& member, const std::string& port,
                                              Instant now) const;

 private:
  using Key = std::pair<std::uint32_t, std::string>;  // module and input
  struct Force {
    channel::Link link;
    std::string json;    // the value
    std::string client;  // the client that renews the force
    std::string by;
    Instant until{};
    Instant renewed{};
    std::uint64_t entered = 0;  // how often the module had been put into the tables when the force began
  };
  struct Ended {
    std::string client;
    std::string why;
  };

  [[nodiscard]] Result<const model::Port*> input(const Member& member, const std::string& name) const;
  [[nodiscard]] Result<channel::Link> link_of(const Member& member, const model::Port& port) const;
  [[nodiscard]] std::string path(const Member& member, const std::string& port) const;
  Result<std::string> begin(const Member& member, const ForceRequest& request, Instant now);
  Result<std::string> renew(const Member& member, const ForceRequest& request, Instant now);
  void drop(std::map<Key, Force>::iterator at, const std::string& why);

  Parts& parts_;
  const std::vector<std::unique_ptr<Member>>& members_;
  const FaultNotes& notes_;
  std::function<void(const Member&, const std::string&)> log_;
  std::map<Key, Force> forces_;
  std::map<Key, Ended> ended_;  // why the last force of each input ended, for its client
  std::uint32_t last_ = 0;      // number of the newest force; the forces of one link have different numbers
};

}  // namespace takt::supervision
