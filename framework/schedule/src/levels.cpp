#include <takt/schedule/levels.hpp>

#include <algorithm>
#include <iterator>
#include <set>

#include <takt/core/check.hpp>

namespace takt::schedule {

int program_level(const model::Device& device, const ExecutorPlan& plan, std::uint32_t module) {
  const bool periodic = device.modules[module].operation == model::Operation::periodic;
  std::set<int> priorities;
  for (const auto index : periodic ? plan.periodic : plan.sporadic) {
    if (device.modules[index].type == model::ModuleType::process)
      priorities.insert(device.modules[index].priority);
  }
  const auto own = priorities.find(device.modules[module].priority);
  TAKT_CHECK(own != priorities.end());
  auto place = static_cast<int>(std::distance(priorities.begin(), own));
  const auto count = static_cast<int>(priorities.size());
  const int levels = periodic ? kPeriodicLevels : kSporadicLevels;
  if (count > levels) place = place * levels / count;
  const int highest = periodic ? plan.priority - 1 : sporadic_level(plan.priority) - 1;
  return std::max(highest - place, 1);
}

}  // namespace takt::schedule
