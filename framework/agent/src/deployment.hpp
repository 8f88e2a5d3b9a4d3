// The data of the deployment that an agent carries out, and of the transaction that leads to it.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/agent/agent.hpp>
#include <takt/transaction/transaction.hpp>

namespace takt::agent {

/// A change of the cell in which this device takes part: a deployment or an update.
struct Agent::Transaction {
  std::string id;  ///< that of the deployment or the update
  transaction::State state{};
  std::optional<Instant> t0{};         ///< T0 of `state` on the monotonic clock, converted once
  std::vector<std::string> devices{};  ///< the devices that take part
  bool complete = false;               ///< this device has everything that it needs to go forward
};

/// Returns a text that identifies the client of a command. The ids of one client's commands differ only after
/// the last '-'.
[[nodiscard]] inline std::string client_of(const Command& command) {
  const std::string id = command.id().to_string();
  return id.substr(0, id.rfind('-'));
}

/// Returns who sent a command: its authenticated sender or, in a cell without DDS Security, the name that the
/// client gives. This name has no ':', because the fault record writes ": " after it.
[[nodiscard]] inline std::string sender_of(const wire::WholeCommand& command) {
  if (!command.who.empty()) return command.who;
  std::string name = command.head.value().to_string();
  std::ranges::replace(name, ':', '_');
  return name.empty() ? "an unknown client" : name;
}

[[nodiscard]] inline bool is_given_up(const LifecycleStatus& module) {
  return module.state() == STATE_DESTRUCT && module.event() == EVENT_GIVE_UP;
}

struct Agent::Deployment {
  std::string id;
  std::string file;
  std::string text;
  bool require_real_time = false;
  model::Cell cell;
  std::size_t device = 0;

  std::unique_ptr<Inspection> inspection;  ///< the inspection, while it is in progress
  Inspected found;  ///< the result of `inspection`; later swaps change `paths` and `builds`
  std::shared_ptr<Supervised> supervised;  ///< null until the inspection has succeeded
  std::string description;                 ///< JSON; empty until it is requested
  std::unique_ptr<Inspection> describing;  ///< the inspection that makes the description
  std::vector<Command> describers;         ///< commands to be answered with the description
  std::optional<Command> swap;             ///< the swap in progress; it begins with `swap_inspection`
  std::unique_ptr<Inspection> swap_inspection;
  std::map<std::string, std::string> swapped;  ///< by module: files swapped in since the deployment
  std::map<std::string, std::map<std::string, std::string>> set;  ///< by module: properties set since the
                                                                  ///< deployment
  std::vector<LifecycleStatus> modules;  ///< the status of each module, as published last

  std::vector<Command> undeployers;  ///< commands to be answered when the deployment has ended
  Transaction transaction;           ///< the transaction that led to this descriptor
  std::int64_t t0_ns = 0;  ///< the time from which releases are counted, on the wall clock; 0: not known yet
  std::optional<Instant> t0;  ///< the same time on the monotonic clock, converted once
  std::string safe;           ///< safe values of the cell's outputs, in the format of model::parse_safe()
  std::string undone;  ///< the reason why the agent ends the deployment without a command; empty if the
                       ///< agent does not
  bool began = false;  ///< the modules have T0
  bool undone_elsewhere = false;  ///< `undone` says that another device has undone the deployment
  bool ended_elsewhere = false;   ///< `undone` says that the deployment was undeployed on another device
  bool stopped = false;           ///< an operator, another device or the node has stopped it
  bool over = false;              ///< true: the deployment has ended by itself; its status can still be read
  bool replaced = false;          ///< ends because the update in Agent::gone_ is final

  [[nodiscard]] const model::Device& of_device() const { return cell.devices[device]; }
  [[nodiscard]] bool is_final() const { return transaction.state.stage == transaction::Stage::final; }
  /// Returns the id of the last update of this deployment, or an empty string if it was never updated.
  [[nodiscard]] std::string update() const { return transaction.id == id ? std::string{} : transaction.id; }
  /// Returns true if the device is part of the cell that the descriptor describes. False after an update has
  /// removed the device.
  [[nodiscard]] bool has_device() const { return !text.empty(); }
  /// Returns the index of a module, which the device must have.
  [[nodiscard]] std::size_t index_of(const std::string& module) const;
  /// Returns the file and build of a module's component, for example "servo.so 1.2.0 3fa91c02". Empty if the
  /// module or the build is not known.
  [[nodiscard]] std::string component_of(const std::string& module) const;
  /// Returns the ports of the device's modules as JSON: {"modules": [{"name", "ports": [...] or null}]}.
  [[nodiscard]] static nlohmann::ordered_json ports_of(const model::Device& device, const Inspected& found);
  /// Copies the swaps and property values that operators made in deployment `other`, if both descriptors
  /// state the same file or property value.
  void inherit(const Deployment& other);
  /// The releases of a new deployment are counted from the transaction's T0.
  void take_t0();
  /// Takes the descriptor of `next`, to which this deployment was updated.
  void take_over(const Deployment& next);
  /// Returns a copy of the deployment that has not been started yet. The copy has the same T0, so its
  /// releases are at the same instants.
  [[nodiscard]] std::unique_ptr<Deployment> afresh() const;
};

}  // namespace takt::agent
