#include "bring_up.hpp"

#include <cstdio>

#include <takt/dds/words.hpp>

#include "screen_style.hpp"

namespace takt::tool {

namespace {

std::size_t modules_of(const model::Cell& cell) {
  std::size_t modules = 0;
  for (const model::Device& device : cell.devices) modules += device.modules.size();
  return modules;
}

}  // namespace

BringUpProgress::BringUpProgress(const Client& client, const model::Cell& cell)
    : client_(client), cell_(cell), bring_up_(modules_of(cell)) {}

void BringUpProgress::say(const std::string& text) {
  progress_.clear();
  std::fprintf(stderr, "%s ...\n", text.c_str());
}

void BringUpProgress::end(bool went_well) {
  if (progress_.is_seen() && went_well) show();
  progress_.clear();
}

void BringUpProgress::show() {
  std::vector<BroughtUp> devices;
  for (const dds::SeenDevice& seen : client_.observer->devices()) {
    if (!seen.alive || seen.status.cell().to_string() != cell_.name) continue;
    BroughtUp device{.device = seen.name(), .state = to_text(seen.status.state()), .modules = {}};
    for (const auto& [name, status] : seen.deployment.modules) device.modules[name] = to_text(status.state());
    devices.push_back(std::move(device));
  }
  for (const std::string& line : bring_up_.news(devices)) progress_.keep(line);
  progress_.show(bring_up_.text(devices, {.unicode = is_utf8()}));
}

}  // namespace takt::tool
