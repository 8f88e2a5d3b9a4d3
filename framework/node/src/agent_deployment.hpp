// What an agent knows of its deployment.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "agent.hpp"

namespace takt::node {

struct Agent::Deployment {
  std::string id;
  std::string file;
  std::string text;
  bool require_real_time = false;
  model::Cell cell;
  std::size_t device = 0;

  std::unique_ptr<Inspection> inspection;  ///< while it is under way
  Inspected found;                         ///< what it found; paths also of what was swapped in since
  std::unique_ptr<Supervised> supervised;  ///< after that
  std::string description;                 ///< JSON; empty: nobody has asked yet
  std::unique_ptr<Inspection> describing;  ///< for who has
  std::vector<Command> describers;
  std::optional<Command> swap;                 ///< that is looked at or carried out
  std::unique_ptr<Inspection> looking;         ///< at its file
  std::map<std::string, std::string> swapped;  ///< files of modules that were swapped since it was deployed
  std::map<std::string, std::map<std::string, std::string>> set;  ///< properties of modules, the same
  std::vector<LifecycleStatus> modules;                           ///< as last told

  std::vector<Command> preparers;    ///< to be answered when every module is in START, or why not
  std::vector<Command> undeployers;  ///< to be answered when it has ended
  std::optional<Instant> ready_since;
  std::optional<std::int64_t> t0_wall_ns;  ///< to run from then on
  std::optional<Instant> t0;               ///< the same, once the wall clock is not asked any more
  bool unkept = false;                     ///< it could not be written to disk, which is tried again
  std::string safe;    ///< values of the cell's outputs, as model::parse_safe() reads them
  std::string undone;  ///< why it is undone before it ran; empty: it is not
  bool over = false;   ///< it ended by itself and is kept to be looked at

  [[nodiscard]] const model::Device& of_device() const { return cell.devices[device]; }
  /// Of a module that the device has.
  [[nodiscard]] std::size_t index_of(const std::string& module) const;
  /// The ports of its modules: {"modules": [{"name", "ports": [...] or null}]}.
  [[nodiscard]] static nlohmann::ordered_json ports_of(const model::Device& device, const Inspected& found);
  /// What operators have swapped and set on another one stays where the descriptor's word on it is the same.
  void inherit(const Deployment& other);
  /// What another one is brought up from that is as this one was, on the same grid.
  [[nodiscard]] std::unique_ptr<Deployment> afresh() const;
};

}  // namespace takt::node
