#include "commands/bring_up.hpp"

#include <algorithm>

#include <takt/wire/words.hpp>

#include "terminal/screen_style.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

std::size_t modules_of(const model::Cell& cell) {
  std::size_t modules = 0;
  for (const model::Device& device : cell.devices) modules += device.modules.size();
  return modules;
}

constexpr Nanoseconds kLate = std::chrono::seconds{2};

/// True if every module of the cell is ready: the module has reported the state START or a later state.
bool are_ready(const std::vector<wire::ObservedDevice>& seen, const model::Cell& cell) {
  const auto is_ready = [&seen](const model::Device& device, const model::Module& module) {
    return std::any_of(seen.begin(), seen.end(), [&](const wire::ObservedDevice& one) {
      const auto status = one.deployment.modules.find(module.name);
      return one.name() == device.name && one.alive && status != one.deployment.modules.end() &&
             status->second.state() != STATE_IDLE && status->second.state() != STATE_INITIALIZE;
    });
  };
  return std::all_of(cell.devices.begin(), cell.devices.end(), [&](const model::Device& device) {
    return std::all_of(device.modules.begin(), device.modules.end(),
                       [&](const model::Module& module) { return is_ready(device, module); });
  });
}

}  // namespace

BringUpProgress::BringUpProgress(const client::Connection& client, const model::Cell& cell)
    : client_(client), cell_(cell), bring_up_(modules_of(cell)) {}

void BringUpProgress::print(const std::string& text) {
  progress_.clear();
  tell(text + " ...");
}

void BringUpProgress::end(bool went_well) {
  if (progress_.is_seen() && went_well) {
    // The devices have reported that they are ready, but the states of their modules come on another topic
    // and may arrive later. Wait for them.
    client_.observer->wait([this](const auto& devices) { return are_ready(devices, cell_); }, kLate);
    show();
  }
  progress_.clear();
}

void BringUpProgress::show() {
  std::vector<BroughtUp> devices;
  for (const wire::ObservedDevice& seen : client_.observer->devices()) {
    if (!seen.alive || seen.status.cell().to_string() != cell_.name) continue;
    BroughtUp device{.device = seen.name(), .state = to_text(seen.status.state()), .modules = {}};
    for (const auto& [name, status] : seen.deployment.modules) device.modules[name] = to_text(status.state());
    devices.push_back(std::move(device));
  }
  for (const std::string& line : bring_up_.news(devices)) progress_.keep(line);
  progress_.show(bring_up_.text(devices, {.unicode = is_utf8()}));
}

}  // namespace takt::tool
