// Deploys, updates and undeploys simulated cells while links are cut, devices lose their power, and nodes and
// the operator stand still. Then all devices must run the same version, and the operator must have told the
// truth.
#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <full_form.hpp>

#include "simulated.hpp"

namespace takt::simulation::transactions_test {
namespace {

using simulated::Cell;
using simulated::thread;
using std::chrono::milliseconds;
using std::chrono::seconds;
using Kind = Injection::Kind;

Cell cell_of(std::uint32_t devices, const std::string& period, const std::string& file) {
  std::string text;
  for (std::uint32_t i = 0; i < devices; ++i)
    text += "<device name=\"d" + std::to_string(i) + "\">" + thread("m", period) + "</device>";
  return Cell::of(text, file);
}

/// Checks that no device begins a deployment or update before all devices are armed for it.
class Armed final : public Listener {
 public:
  explicit Armed(std::uint32_t devices) : devices_(devices), newest_(devices) {}

  void on_event(const Event& event) override {
    if (event.what != What::begins) return;
    const DeviceStatus& status = newest_[event.device];
    const std::string id = status.transaction().to_string();
    // A device that goes back, or that restores the cell, begins what was final before.
    if (status.stage() == STAGE_UNDONE || is_final_.count(id) != 0) return;
    if (armed_[id].size() < devices_) too_early_ += (too_early_.empty() ? "" : ", ") + id;
  }
  void on_status(std::uint32_t device, const DeviceStatus& status) override {
    newest_[device] = status;
    const std::string id = status.transaction().to_string();
    if (status.stage() >= STAGE_ARMED) armed_[id].insert(device);
    if (status.stage() == STAGE_FINAL) is_final_.insert(id);
  }
  [[nodiscard]] const std::string& too_early() const noexcept { return too_early_; }

 private:
  const std::uint32_t devices_;
  std::vector<DeviceStatus> newest_;
  std::map<std::string, std::set<std::uint32_t>> armed_;
  std::set<std::string> is_final_;
  std::string too_early_;
};

struct Plan {
  std::vector<Injection> injections;
  Nanoseconds whole{};  ///< when the last fault is over
  Nanoseconds message_delay{};
};

/// Draws one to three actions of the operator, and one to three faults while they are in progress.
Plan draw(Draws& draws, std::uint32_t devices) {
  Plan plan;
  bool deployed = true;
  Nanoseconds at{milliseconds{300}};
  const std::uint64_t actions = 1 + draws.below(3);
  for (std::uint64_t i = 0; i < actions; ++i) {
    const Kind kind = !deployed ? Kind::deploy : draws.chance(0.7) ? Kind::update : Kind::undeploy;
    deployed = kind != Kind::undeploy;
    plan.injections.push_back({.kind = kind, .at = at});
    at += draws.between(Nanoseconds{milliseconds{50}}, Nanoseconds{seconds{2}});
  }
  plan.whole = at + seconds{2};
  if (draws.chance(0.7)) plan.message_delay = draws.between(Nanoseconds{0}, Nanoseconds{milliseconds{150}});
  const std::uint64_t faults = 1 + draws.below(3);
  for (std::uint64_t i = 0; i < faults; ++i) {
    static const std::vector<Kind> kinds{Kind::cut, Kind::down, Kind::pause};
    const Nanoseconds during = plan.injections[draws.below(actions)].at;
    Injection fault{.kind = kinds[draws.below(kinds.size())],
                    .at = during + draws.between(Nanoseconds{0}, Nanoseconds{milliseconds{700}}),
                    .device = static_cast<std::uint32_t>(draws.below(devices + 1)),
                    .target = static_cast<std::uint32_t>(draws.below(devices + 1)),
                    .by = draws.between(Nanoseconds{milliseconds{50}}, Nanoseconds{milliseconds{600}})};
    if (draws.chance(0.5)) fault.by *= 10;
    if (fault.kind == Kind::cut && fault.device == fault.target)
      fault.target = (fault.device + 1) % (devices + 1);
    plan.injections.push_back(fault);
    plan.whole = std::max(plan.whole, fault.at + fault.by);
  }
  return plan;
}

/// Returns what the devices and the operator did wrong; empty if they did nothing wrong.
std::string wrong_with(std::uint64_t seed) {
  Draws draws{seed, "plan"};
  const auto devices = static_cast<std::uint32_t>(2 + draws.below(2));
  const Cell cell = cell_of(devices, "50000000", "cell.xml");
  const Version update = cell_of(devices, "100000000", "new.xml").version();
  const Plan plan = draw(draws, devices);
  Armed armed{devices};
  const auto plans = *schedule::plan(cell.model());
  const auto course = simulate(cell.model(), plans, {},
                               {.seed = seed,
                                .length = plan.whole + seconds{25},
                                .injections = plan.injections,
                                .listener = &armed,
                                .message_delay = plan.message_delay,
                                .update = &update});
  if (!course) return to_text(course.problems());
  std::string wrong;
  for (const std::string& violation : course->violations) wrong += violation + "\n";
  if (!armed.too_early().empty()) wrong += "began before all were armed: " + armed.too_early() + "\n";
  const auto& ran = course->ran;
  if (std::set(ran.begin(), ran.end()).size() != 1) wrong += "the devices do not run the same\n";
  const auto undeploys = [](const Injection& one) { return one.kind == Kind::undeploy; };
  if (!ran[0] && std::none_of(plan.injections.begin(), plan.injections.end(), undeploys))
    wrong += "the devices do not run\n";
  for (const Report& report : course->reports) {
    if (report.outcome == simulation::Outcome::done && !report.why.empty())
      wrong += "the operator reported: " + to_text(report) + "\n";
  }
  if (!course->reports.empty()) {
    const Report& last = course->reports.back();
    const std::optional<std::uint32_t> expected = last.action == Action::update   ? std::optional{1U}
                                                  : last.action == Action::deploy ? std::optional{0U}
                                                                                  : std::nullopt;
    const auto is_last = [&](const Injection& one) {
      return one.kind == Kind::down && one.device == devices;
    };
    const bool operator_died = std::any_of(plan.injections.begin(), plan.injections.end(), is_last);
    if (!operator_died && last.outcome == simulation::Outcome::done && ran[0] != expected)
      wrong += "the operator reported: " + to_text(last) + "\n";
    if (!operator_died && last.outcome == simulation::Outcome::unchanged && last.action != Action::undeploy &&
        ran[0] == expected && course->reports.size() == 1)
      wrong += "the operator reported: " + to_text(last) + "\n";
  }
  if (wrong.empty()) return wrong;
  for (const Injection& one : plan.injections) wrong += to_text(one, cell.model()) + "\n";
  for (const Report& report : course->reports) wrong += to_text(report) + "\n";
  for (const auto& version : ran) wrong += version ? (*version == 0 ? "old " : "new ") : "none ";
  return wrong;
}

TEST(Transactions, EndOnAllDevicesInTheSameWayWhateverFails) {
  const std::uint64_t seeds = full_form() ? 5000 : kSanitized ? 4 : 100;
  std::uint64_t failed = 0;
  for (std::uint64_t seed = 1; seed <= seeds && failed < 5; ++seed) {
    const std::string wrong = wrong_with(seed);
    if (!wrong.empty()) ++failed;
    EXPECT_EQ(wrong, "") << "seed " << seed;
  }
}

}  // namespace
}  // namespace takt::simulation::transactions_test
