#include <takt/wire/cell_state.hpp>

#include <algorithm>

#include <takt/wire/words.hpp>

namespace takt::wire {

namespace {

template <class Status>
std::string device_path(const Status& status) {
  return path_of(status.cell().to_string(), status.device().to_string());
}

// Returns the path without its last name: CELL/DEVICE for CELL/DEVICE/MODULE.
std::string parent(const std::string& path) { return path.substr(0, path.rfind('/')); }
std::string last(const std::string& path) { return path.substr(path.rfind('/') + 1); }

}  // namespace

bool is_stopped(const LifecycleStatus& module) noexcept {
  return module.state() == STATE_START && (module.event() == EVENT_STOP || module.event() == EVENT_RECOVER);
}

bool awaits_release(const LifecycleStatus& module) noexcept {
  return module.state() == STATE_START && !is_stopped(module);
}

void CellState::receive(const DeviceStatus& status, WriterId writer) {
  const std::string id = status.node().to_string();
  // A new node of a device replaces the lost node of this device.
  std::erase_if(nodes_, [&](const auto& entry) {
    const Node& other = entry.second;
    if (entry.first == id || other.alive || other.status.device() != status.device()) return false;
    // If the new node has resumed the same cell, the states of its modules may have arrived before the status
    // of the node. So do not delete these states.
    if (other.status.cell() != status.cell()) deployments_.erase(device_path(other.status));
    return true;
  });
  const auto known = nodes_.find(id);
  std::uint64_t back_at = 0;
  if (known != nodes_.end()) back_at = known->second.alive ? known->second.back_at : status.sequence_number();
  nodes_[id] = {.status = status, .writer = writer, .alive = true, .back_at = back_at};
}

void CellState::receive(const LifecycleStatus& status) {
  deployments_[device_path(status)].modules[status.name().to_string()] = status;
}

void CellState::receive(const ModuleStatistics& statistics) {
  deployments_[device_path(statistics)].statistics[statistics.name().to_string()] = statistics;
}

void CellState::receive(const ExecutorStatistics& statistics) {
  deployments_[device_path(statistics)].executors[statistics.name().to_string()] = statistics;
}

void CellState::receive(const PortStatus& status) {
  ObservedPort& port =
      deployments_[device_path(status)].ports[status.name().to_string() + "." + status.port().to_string()];
  port.status = status;
  const Nanoseconds at{status.time_ns()};
  port.lost.update(status.lost(), at);
  port.dropped.update(status.dropped(), at);
}

void CellState::remove(const DeviceStatus& key, WriterId writer) {
  // A node that changes its key publishes the new key before it disposes of the old one. So the node has
  // ended only if the last status received from the node has the disposed key.
  std::erase_if(nodes_, [&](const auto& entry) {
    return entry.second.writer == writer && entry.second.status.path() == key.path();
  });
}

void CellState::remove(const LifecycleStatus& key) {
  const std::string path = key.path().to_string();
  const auto found = deployments_.find(parent(path));
  if (found == deployments_.end()) return;
  const std::string module = last(path);
  found->second.modules.erase(module);
  found->second.statistics.erase(module);
  std::erase_if(found->second.ports,
                [&](const auto& entry) { return entry.first.starts_with(module + "."); });
  if (found->second.modules.empty()) deployments_.erase(found);
}

void CellState::lost(WriterId writer) {
  for (auto& [id, node] : nodes_) {
    if (node.writer == writer) node.alive = false;
  }
}

bool CellState::executes(const std::string& cell, const std::string& device,
                         const std::string& module) const {
  const bool alive = std::any_of(nodes_.begin(), nodes_.end(), [&](const auto& entry) {
    const Node& node = entry.second;
    return node.alive && node.status.device() == device && node.status.cell() == cell &&
           (node.back_at == 0 || node.status.sequence_number() > node.back_at);
  });
  const auto deployment = deployments_.find(path_of(cell, device));
  if (!alive || deployment == deployments_.end()) return false;
  const auto found = deployment->second.modules.find(module);
  return found != deployment->second.modules.end() && found->second.state() == STATE_EXECUTING;
}

bool CellState::has_lost(const std::string& device) const {
  bool known = false;
  for (const auto& [id, node] : nodes_) {
    if (node.status.device() != device) continue;
    if (node.alive) return false;
    known = true;
  }
  return known;
}

std::vector<CellState::LastStatus> CellState::of_deployment(const std::string& id,
                                                            const std::string& but) const {
  std::vector<LastStatus> found;
  for (const auto& [node_id, node] : nodes_) {
    const bool has_it = node.status.deployment() == id || node.status.transaction() == id;
    if (has_it && node.status.device() != but) found.push_back({node.status, node.alive});
  }
  return found;
}

std::vector<CellState::LastStatus> CellState::of_device(const std::string& name) const {
  std::vector<LastStatus> found;
  for (const auto& [node_id, node] : nodes_) {
    if (node.status.device() == name) found.push_back({node.status, node.alive});
  }
  return found;
}

ObservedDevice CellState::seen(const Node& node) const {
  ObservedDevice device{.status = node.status, .alive = node.alive, .deployment = {}};
  const auto found = deployments_.find(device_path(node.status));
  if (found != deployments_.end()) device.deployment = found->second;
  return device;
}

std::vector<ObservedDevice> CellState::devices() const {
  std::vector<ObservedDevice> all;
  all.reserve(nodes_.size());
  for (const auto& [id, node] : nodes_) all.push_back(seen(node));
  std::stable_sort(all.begin(), all.end(),
                   [](const ObservedDevice& a, const ObservedDevice& b) { return a.name() < b.name(); });
  return all;
}

std::vector<ObservedDevice> CellState::devices(const std::string& name) const {
  std::vector<ObservedDevice> all;
  for (const auto& [id, node] : nodes_) {
    if (node.status.device() == name) all.push_back(seen(node));
  }
  return all;
}

}  // namespace takt::wire
