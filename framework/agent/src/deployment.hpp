// The state of an agent's deployment.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/agent/agent.hpp>

namespace takt::agent {

struct Agent::Deployment {
  std::string id;
  std::string file;
  std::string text;
  bool require_real_time = false;
  model::Cell cell;
  std::size_t device = 0;

  std::unique_ptr<Inspection> inspection;  ///< the inspection, while it is in progress
  Inspected found;                         ///< its result; later swaps change `paths`
  std::unique_ptr<Supervised> supervised;  ///< null until the inspection has succeeded
  std::string description;                 ///< JSON; empty until it is requested
  std::unique_ptr<Inspection> describing;  ///< the inspection that makes the description
  std::vector<Command> describers;         ///< to be answered with the description
  std::optional<Command> swap;             ///< the swap whose file is inspected or that is carried out
  std::unique_ptr<Inspection> swap_inspection;
  std::map<std::string, std::string> swapped;  ///< by module: files swapped in since the deployment
  std::map<std::string, std::map<std::string, std::string>> set;  ///< by module: properties set since the
                                                                  ///< deployment
  std::vector<LifecycleStatus> modules;                           ///< as last published

  std::vector<Command> preparers;    ///< to be answered when every module is in START, or on failure
  std::vector<Command> undeployers;  ///< to be answered when the deployment has ended
  std::optional<Instant> ready_since;
  std::optional<std::int64_t> t0_wall_ns;  ///< T0 on the wall clock
  std::optional<Instant> t0;               ///< T0 on the monotonic clock, converted once
  bool unsaved = false;                    ///< writing it to disk has failed and is tried again
  std::string safe;    ///< safe values of the cell's outputs, in the format of model::parse_safe()
  std::string undone;  ///< why it is undone before it has run; empty if it is not undone
  bool over = false;   ///< it ended by itself and is kept for its status

  [[nodiscard]] const model::Device& of_device() const { return cell.devices[device]; }
  /// The index of a module, which the device must have.
  [[nodiscard]] std::size_t index_of(const std::string& module) const;
  /// The ports of its modules: {"modules": [{"name", "ports": [...] or null}]}.
  [[nodiscard]] static nlohmann::ordered_json ports_of(const model::Device& device, const Inspected& found);
  /// Takes over the swaps and property values that operators made in another deployment, wherever both
  /// descriptors agree.
  void inherit(const Deployment& other);
  /// A copy that can be brought up again on the same grid.
  [[nodiscard]] std::unique_ptr<Deployment> afresh() const;
};

}  // namespace takt::agent
