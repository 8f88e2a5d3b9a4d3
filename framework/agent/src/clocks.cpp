// Compares the wall clock of this device with the clocks of the other devices of its cell.
#include "clocks.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>

#include <nlohmann/json.hpp>

#include <takt/agent/agent.hpp>
#include "deployment.hpp"
#include "limits.hpp"

namespace takt::agent {

using json = nlohmann::ordered_json;

namespace {

std::int64_t middle(const ClockBounds& bounds) {
  return bounds.low_ns + (bounds.high_ns - bounds.low_ns) / 2;
}
std::int64_t half_width(const ClockBounds& bounds) { return (bounds.high_ns - bounds.low_ns + 1) / 2; }

std::string rounded(std::int64_t ns) {
  using namespace std::chrono;
  const Nanoseconds time{ns};
  return takt::to_text(time < seconds{1} ? Nanoseconds{round<microseconds>(time)}
                                         : round<milliseconds>(time));
}

bool agree(const ClockBounds& ahead) noexcept {
  return ahead.low_ns >= -kClocksDiffer.count() && ahead.high_ns <= kClocksDiffer.count();
}

}  // namespace

bool differ(const ClockBounds& ahead) noexcept {
  return ahead.low_ns > kClocksDiffer.count() || ahead.high_ns < -kClocksDiffer.count();
}

std::string difference_text(const std::string& own, const std::string& other, const ClockBounds& ahead) {
  const std::int64_t by = middle(ahead);
  return "the clock of device " + own + " is " + rounded(std::abs(by)) + (by < 0 ? " ahead of" : " behind") +
         " the clock of device " + other + " (±" + rounded(half_width(ahead)) + "), more than the allowed " +
         takt::to_text(kClocksDiffer) +
         "; synchronise the clocks of the two machines, for example with chrony or ptp4l";
}

void Agent::receive(const DeviceStatus& status, wire::WriterId writer, Instant arrived) {
  others_.receive(status, writer);
  if (status.node() == options_.node) return;
  const std::string device = status.device().to_string();
  if (!clocks_.contains(device))
    std::erase_if(clocks_, [this](const auto& entry) { return others_.of_device(entry.first).empty(); });
  OtherClock& clock = clocks_[device];
  if (const std::string node = status.node().to_string(); clock.node != node) {
    clock.node = node;
    clock.offset = {};
  }
  clock.offset.heard(status.time_ns(), arrived);
  for (const StatusEcho& echo : status.echoes()) {
    if (echo.node() == options_.node)
      clock.offset.answered(status.time_ns(), from_ns(echo.monotonic_ns()), Nanoseconds{echo.held_ns()},
                            arrived);
  }
}

// Returns bounds on the wall clock of the device minus the monotonic clock of this device.
std::optional<ClockBounds> Agent::clock_of(const std::string& device) const {
  const auto found = clocks_.find(device);
  return found == clocks_.end() ? std::nullopt : found->second.offset.at(options_.now());
}

// Returns bounds on the wall clock of the device minus the wall clock of this device.
std::optional<ClockBounds> Agent::ahead(const std::string& device) const {
  auto bounds = clock_of(device);
  if (!bounds) return bounds;
  const std::int64_t own = options_.wall_ns() - to_ns(options_.now());
  return ClockBounds{.low_ns = bounds->low_ns - own, .high_ns = bounds->high_ns - own};
}

// Returns bounds on the wall clock of the first device of the cell minus the wall clock of this device. None
// if this is not known, and for a cell of one device.
std::optional<ClockBounds> Agent::first_ahead() const {
  if (present() == nullptr || present()->cell.devices.size() < 2) return std::nullopt;
  const std::string& first = present()->cell.devices.front().name;
  return first == options_.device ? ClockBounds{} : ahead(first);
}

void Agent::add_clock(DeviceStatus& status) const {
  const auto bounds = first_ahead();
  if (!bounds) return;
  status.clock_offset_ns(-middle(*bounds));
  status.clock_error_ns(half_width(*bounds));
}

// Returns how far the clock of this device is ahead of the clock of the first device of the cell; null if
// this is not known, and for a cell of one device.
json Agent::clock_report() const {
  const auto bounds = first_ahead();
  if (!bounds) return nullptr;
  return {{"reference", present()->cell.devices.front().name},
          {"offset_us", static_cast<double>(-middle(*bounds)) / 1000},
          {"bound_us", static_cast<double>(half_width(*bounds)) / 1000}};
}

// Records when the clock of another device of the cell begins to differ too much, and when it agrees again.
void Agent::check_clocks() {
  if (!deployment_ || !deployment_->is_final() || deployment_->over) return;
  for (const model::Device& device : deployment_->cell.devices) {
    const auto bounds = ahead(device.name);
    if (!bounds) continue;
    bool& differs = clocks_[device.name].differs;
    const bool before = differs;
    differs = before ? !agree(*bounds) : differ(*bounds);
    if (differs == before) continue;
    const std::string cause = differs ? difference_text(options_.device, device.name, *bounds)
                                      : "the clock of device " + options_.device +
                                            " agrees again with the clock of device " + device.name;
    log((differs ? "warning: " : "") + cause);
    note({.kind = differs ? model::FaultKind::clocks_differ : model::FaultKind::clocks_agree, .cause = cause},
         device.name);
  }
}

}  // namespace takt::agent
