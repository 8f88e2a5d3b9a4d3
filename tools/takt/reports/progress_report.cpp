#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "terminal/progress.hpp"
#include "watch/sparkline.hpp"

namespace takt::tool {

std::string share_text(double share, const std::string& of, ScreenStyle style) {
  constexpr std::size_t kBar = 20;
  const double shown = std::clamp(share, 0.0, 1.0);
  return fmt::format("[{}] {:>3.0f} %  {}", watch::bar(shown, kBar, style), shown * 100, of);
}

std::vector<std::string> BringUp::news(const std::vector<BroughtUp>& devices) {
  std::vector<std::string> lines;
  const auto report = [&](const std::string& name, const std::string& state) {
    if (std::exchange(reported_[name], state) != state) lines.push_back(name + ": " + state);
  };
  for (const BroughtUp& device : devices) {
    for (const auto& [name, state] : device.modules) {
      if (state == "START" || state == "EXECUTING" || state == "RECOVER" || state == "DESTRUCT")
        report(device.device + "." + name, state);
    }
    if (device.state != "waiting") report(device.device, device.state);
  }
  return lines;
}

std::string BringUp::text(const std::vector<BroughtUp>& devices, ScreenStyle style) const {
  std::size_t ready = 0;
  std::string waited_for;
  for (const BroughtUp& device : devices) {
    for (const auto& [name, state] : device.modules) {
      const bool is_ready = state == "START" || state == "EXECUTING";
      ready += is_ready ? 1 : 0;
      if (!is_ready && waited_for.empty()) waited_for = ", " + device.device + "." + name + " is in " + state;
    }
  }
  const double share = modules_ == 0 ? 1 : static_cast<double>(ready) / static_cast<double>(modules_);
  return share_text(
      share, fmt::format("{} of {} modules ready{}", std::min(ready, modules_), modules_, waited_for), style);
}

}  // namespace takt::tool
