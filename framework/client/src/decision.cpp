#include "decision.hpp"

#include <algorithm>

#include "answers.hpp"

namespace takt::client {

namespace {

constexpr Nanoseconds kShortestLead = std::chrono::milliseconds{500};
constexpr Nanoseconds kLongestLead = std::chrono::milliseconds{1000};
/// Each device must confirm T0 at least this time before T0.
constexpr Nanoseconds kConfirmed = std::chrono::milliseconds{200};
/// The longest time after T0 until every device is final or has gone back.
constexpr Nanoseconds kDecided = std::chrono::seconds{6};

Stands stands(const std::vector<wire::ObservedDevice>& seen, const std::string& device,
              const Undecided& what) {
  Stands found = Stands::lost;
  for (const wire::ObservedDevice& one : seen) {
    if (!one.alive || one.name() != device) continue;
    const DeviceStatus& status = one.status;
    const bool has_t0 = status.transaction() == what.id && status.t0_ns() == what.t0_ns;
    if (!has_t0 || status.stage() == STAGE_UNDONE || status.undeployed() == what.deployment) {
      // Before T0, an older status may still be on its way.
      if (found == Stands::lost) found = wall_ns() > what.t0_ns ? Stands::undone : Stands::undecided;
    } else {
      found = status.stage() == STAGE_FINAL ? Stands::final : Stands::undecided;
    }
  }
  return found;
}

}  // namespace

std::int64_t choose_t0(Nanoseconds took) {
  return wall_ns() + std::clamp(10 * took, kShortestLead, kLongestLead).count();
}

std::chrono::milliseconds time_to_confirm(std::int64_t t0_ns) {
  const Nanoseconds left = Nanoseconds{t0_ns - wall_ns()} - kConfirmed;
  return std::max(std::chrono::floor<std::chrono::milliseconds>(left), std::chrono::milliseconds{1});
}

std::vector<Stands> wait_until_decided(const Observer& observer, const std::vector<std::string>& devices,
                                       const Undecided& what, const std::function<bool()>& cancelled) {
  std::vector<Stands> all;
  const auto judge = [&](const std::vector<wire::ObservedDevice>& seen) {
    all.clear();
    for (const std::string& device : devices) all.push_back(stands(seen, device, what));
  };
  observer.wait(
      [&](const std::vector<wire::ObservedDevice>& seen) {
        judge(seen);
        return std::count(all.begin(), all.end(), Stands::undone) != 0 ||
               std::count(all.begin(), all.end(), Stands::final) == std::ssize(all) || cancelled();
      },
      Nanoseconds{what.t0_ns - wall_ns()} + kDecided);
  judge(observer.devices());
  return all;
}

}  // namespace takt::client
