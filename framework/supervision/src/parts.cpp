#include <takt/supervision/parts.hpp>

#include <algorithm>

namespace takt::supervision {

Result<void> Parts::create() {
  const model::Device& self = of_device();
  auto planned = schedule::plan(cell, self);
  if (!planned) return planned.problems();
  plan = std::move(*planned);
  shares = model::hosts_of(self);
  ports.resize(self.modules.size());

  std::vector<std::string> executors;
  std::vector<std::string> modules;
  for (const auto& executor : self.executors) executors.push_back(executor.name);
  for (const auto& module : self.modules) modules.push_back(module.name);
  auto blocks = channel::Channel::create(shares.size(), executors, modules);
  if (!blocks) return blocks.problems();
  channel = std::move(*blocks);
  auto word = channel::Shared<channel::WakeWord>::create("takt-wake_word");
  if (!word) return word.problems();
  wake_word = std::move(*word);
  turns.resize(self.executors.size());
  for (auto& turn : turns) {
    auto memory = channel::Shared<channel::Turn>::create("takt-turn");
    if (!memory) return memory.problems();
    turn = std::move(*memory);
  }
  auto states = channel::Shared<channel::SavedState>::create("takt-saved",
                                                             std::max<std::size_t>(self.modules.size(), 1));
  if (!states) return states.problems();
  saved = std::move(*states);
  slots.resize(self.modules.size());
  for (std::size_t i = 0; i < self.modules.size(); ++i) {
    const model::Module& module = self.modules[i];
    if (module.type != model::ModuleType::process || module.operation == model::Operation::non_real) continue;
    auto slot = channel::Shared<channel::ReleaseSlot>::create("takt-slot");
    if (!slot) return slot.problems();
    slots[i] = std::move(*slot);
  }
  auto wired = Wiring::create(plan_wiring(cell, device, ports));
  if (!wired) return wired.problems();
  wiring = std::move(*wired);
  return {};
}

std::size_t Parts::executor_of(const model::Module& module) const {
  const auto& executors = of_device().executors;
  const auto found = std::find_if(executors.begin(), executors.end(),
                                  [&](const auto& executor) { return executor.name == module.executor; });
  return static_cast<std::size_t>(found - executors.begin());
}

}  // namespace takt::supervision
