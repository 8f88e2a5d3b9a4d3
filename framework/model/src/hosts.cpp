#include <takt/model/hosts.hpp>

#include <algorithm>

namespace takt::model {

std::vector<HostShare> hosts_of(const Device& device) {
  std::vector<HostShare> hosts(1);
  std::vector<std::size_t> of_executor(device.executors.size(), 0);
  for (std::size_t e = 0; e < device.executors.size(); ++e) {
    if (device.executors[e].own_host) {
      of_executor[e] = hosts.size();
      hosts.push_back({.name = device.executors[e].name});
    }
    hosts[of_executor[e]].executors.push_back(e);
  }
  for (std::uint32_t i = 0; i < device.modules.size(); ++i) {
    const Module& module = device.modules[i];
    const auto executor = std::find_if(device.executors.begin(), device.executors.end(),
                                       [&](const Executor& each) { return each.name == module.executor; });
    const bool scheduled = module.operation != Operation::non_real && executor != device.executors.end();
    HostShare& host =
        hosts[scheduled ? of_executor[static_cast<std::size_t>(executor - device.executors.begin())] : 0];
    if (module.type == ModuleType::thread)
      host.modules.push_back(i);
    else if (scheduled)
      host.programs.push_back(i);
  }
  const HostShare& shared = hosts.front();
  if (hosts.size() > 1 && shared.executors.empty() && shared.modules.empty()) hosts.erase(hosts.begin());
  return hosts;
}

}  // namespace takt::model
