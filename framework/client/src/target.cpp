#include <takt/client/target.hpp>

#include <set>
#include <string_view>
#include <vector>

#include <takt/core/words.hpp>
#include <takt/os/clock.hpp>
#include "reports.hpp"

namespace takt::client {

namespace {

/// Returns what to write instead of the name of an unknown device.
std::string instead_of(const std::string& device, const std::string& rest, const Reports& reports,
                       const Operator& sender) {
  const Observer& observer = sender.observer();
  const std::set<std::string> devices = alive(observer.devices());
  const std::string_view near_device = nearest(device, {devices.begin(), devices.end()});
  const bool is_module = rest.empty() && reports.modules.contains(device);
  const std::string found = found_there(sender);
  if (!near_device.empty() && !is_module)
    return found + "; did you mean " + std::string{near_device} + (rest.empty() ? "" : "." + rest) + "?";
  if (rest.empty()) {
    std::vector<std::string_view> names;
    for (const auto& [name, path] : reports.modules) names.emplace_back(name);
    const std::string meant{nearest(device, names)};
    const auto [first, last] = reports.modules.equal_range(meant);
    std::vector<std::string_view> paths;
    for (auto at = first; at != last; ++at) paths.emplace_back(at->second);
    if (!paths.empty()) return "for a module, write DEVICE.MODULE; did you mean " + one_of(paths) + "?";
  }
  return "check that " + sender.node_command(device) + " is running; " + found;
}

}  // namespace

Result<void> find_device(Operator& sender, const std::string& device, const std::string& rest) {
  const Observer& observer = sender.observer();
  const auto is_found = [&](const auto&) { return !observer.devices(device).empty(); };
  if (observer.wait(is_found, kQuiet)) return {};
  const Nanoseconds limit = sender.search_limit();
  const Instant begin = os::now();
  const auto reports = all_reports(sender, device);
  if (!reports)
    return sender.not_found(
        device, std::max(limit, Nanoseconds{std::chrono::floor<std::chrono::seconds>(os::now() - begin)}));
  // If a node has not answered or does not know all other nodes yet, the device may still be discovered.
  const bool complete = reports->problems.empty() && reports->complete(observer);
  if (reports->lost.contains(device)) {
    if (observer.wait(is_found, kQuiet)) return {};  // it may just have come back
    return sender.lost(device, reports->lost.at(device).value("text", ""));
  }
  if (reports->named.contains(device) || sender.search(is_found, complete ? Nanoseconds{0} : limit, {device}))
    return {};
  return Problem{"device " + device, "not found on domain " + std::to_string(sender.domain()),
                 instead_of(device, rest, *reports, sender)};
}

}  // namespace takt::client
