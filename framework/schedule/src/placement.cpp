#include <takt/schedule/placement.hpp>

#include <algorithm>
#include <cstddef>

#include <takt/core/check.hpp>

namespace takt::schedule {

namespace {

bool is_program(const model::Module& module) {
  return module.type == model::ModuleType::process && module.operation != model::Operation::non_real;
}

bool has(const std::vector<int>& cpus, int cpu) {
  return std::find(cpus.begin(), cpus.end(), cpu) != cpus.end();
}

}  // namespace

std::vector<std::string> missing_cpus(const model::Device& device, const model::Cpus& cpus) {
  std::vector<std::string> missing;
  for (const model::Executor& executor : device.executors) {
    if (!executor.cpu || has(cpus.permitted, *executor.cpu)) continue;
    const bool online = has(cpus.online, *executor.cpu);
    missing.push_back(
        "executor " + executor.name +
        (executor.line.given() ? " (line " + std::to_string(executor.line.number) + ")" : "") +
        " requests CPU " + std::to_string(*executor.cpu) +
        (online ? ", which a cpuset limit (of a cgroup, a service or a container) excludes; Takt may use "
                : ", which this machine does not have or has switched off; Takt may use ") +
        model::cpus_in_words(cpus.permitted) + ", and the node chooses one of them");
  }
  return missing;
}

Placement place(const model::Device& device, const model::Cpus& cpus) {
  TAKT_CHECK(!cpus.ordinary.empty());
  Placement placement;
  std::vector<int> taken;
  std::vector<int> free = cpus.ordinary;
  const auto take = [&](int cpu) {
    if (!has(taken, cpu)) taken.push_back(cpu);
    std::erase(free, cpu);
  };
  for (const model::Executor& executor : device.executors) {
    if (executor.cpu && has(cpus.permitted, *executor.cpu)) take(*executor.cpu);
  }
  placement.warnings = missing_cpus(device, cpus);
  for (const model::Executor& executor : device.executors) {
    if (executor.cpu && has(cpus.permitted, *executor.cpu)) {
      placement.executors.push_back({*executor.cpu});
      continue;
    }
    // Leave the last free CPU to the other threads if this executor can share a CPU with another executor.
    const int cpu = free.size() > 1 || taken.empty() ? free.back() : taken.front();
    placement.executors.push_back({cpu});
    take(cpu);
  }
  placement.background = free.empty() ? cpus.ordinary : free;
  if (free.empty() && std::any_of(device.modules.begin(), device.modules.end(), is_program)) {
    placement.warnings.emplace_back(
        "no CPU is left for process modules: they share the CPUs of the executors; give the device another "
        "CPU");
  }
  return placement;
}

int programs_on_one(const model::Device& device, const Placement& placement) {
  const auto programs = std::count_if(device.modules.begin(), device.modules.end(), is_program);
  const auto cpus = static_cast<std::ptrdiff_t>(placement.background.size());
  return static_cast<int>(std::max<std::ptrdiff_t>(1, (programs + cpus - 1) / cpus));
}

}  // namespace takt::schedule
