#include <takt/simulation/simulation.hpp>

#include <algorithm>
#include <memory>

#include <takt/core/check.hpp>
#include "device.hpp"
#include "invariants.hpp"
#include "network.hpp"
#include "simulated_cell.hpp"

namespace takt::simulation {

namespace {

/// The time before T0 in which modules are initialised and started.
constexpr Nanoseconds kLead = std::chrono::milliseconds{150};
/// The maximum time that the devices may take to end. No device needs more, even if something hangs.
constexpr Nanoseconds kEndLimit = std::chrono::seconds{30};
constexpr Nanoseconds kLook = std::chrono::milliseconds{5};
/// The time from a fault that stops the cell until the other devices react to it.
constexpr Nanoseconds kReactionTime = std::chrono::milliseconds{10};

class Both final : public Listener {
 public:
  Both(Listener& first, Listener* second) : first_(first), second_(second) {}
  void on_event(const Event& event) override {
    if (second_ != nullptr) second_->on_event(event);
    first_.on_event(event);
  }

 private:
  Listener& first_;
  Listener* second_;
};

}  // namespace

Result<Course> simulate(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans,
                        const model::CellPorts& ports, const Options& options) {
  Kernel kernel{kT0 - kLead};
  Invariants invariants{cell, plans, kT0};
  Both listener{invariants, options.listener};
  const SimulatedCell simulated = simulated_cell(cell, ports);
  World world{.kernel = kernel,
              .listener = listener,
              .cell = simulated.cell,
              .ports = simulated.ports,
              .profile = options.profile,
              .seed = options.seed,
              .cpus = options.cpus};
  Network network{world};
  world.network = &network;

  std::vector<std::unique_ptr<Device>> devices;
  world.executes = [&](const std::string& name, const std::string& module) {
    for (std::uint32_t i = 0; i < devices.size(); ++i) {
      if (cell.devices[i].name == name) return devices[i]->executes(module);
    }
    return false;
  };
  for (std::uint32_t i = 0; i < cell.devices.size(); ++i) {
    devices.push_back(std::make_unique<Device>(world, i));
    if (auto prepared = devices.back()->prepare(); !prepared) return prepared.problems();
  }
  world.stop_cell = [&](std::uint32_t device, const std::string& why) {
    for (std::uint32_t other = 0; other < devices.size(); ++other) {
      if (other == device) continue;
      kernel.at(kernel.now() + kReactionTime, [&devices, &cell, other, why] {
        devices[other]->stop_for({"device " + cell.devices[other].name, "stops with its cell: " + why, ""});
      });
    }
  };
  const auto all_are = [&devices](Device::Phase phase) {
    return std::all_of(devices.begin(), devices.end(),
                       [phase](const auto& d) { return d->phase() == phase; });
  };
  while (!all_are(Device::Phase::ready)) {
    TAKT_CHECK(kernel.now() < kT0);
    kernel.run_until(kernel.now() + kLook);
  }
  for (auto& device : devices) device->go(kT0);

  Draws draws{options.seed, "faults"};
  std::vector<Injection> injections = draw_injections(cell, draws, options.length, options.faults_per_second);
  injections.insert(injections.end(), options.injections.begin(), options.injections.end());
  for (const Injection& injection : injections) {
    if (injection.at < options.length)
      kernel.at(kT0 + injection.at, [&devices, injection] { devices[injection.device]->inject(injection); });
  }
  constexpr std::int64_t kSteps = 500;
  for (std::int64_t i = 1; options.progress && i < kSteps; ++i) {
    const Nanoseconds passed = options.length / kSteps * i;
    kernel.run_until(kT0 + passed);
    options.progress(passed);
  }
  kernel.run_until(kT0 + options.length);

  for (auto& device : devices) device->stop();
  const Instant limit = kernel.now() + kEndLimit;
  while (!all_are(Device::Phase::ended)) {
    TAKT_CHECK(kernel.now() < limit);
    kernel.run_until(kernel.now() + kLook);
  }

  Course course;
  course.report = {{"cell", cell.name}, {"devices", nlohmann::ordered_json::array()}};
  for (std::uint32_t i = 0; i < devices.size(); ++i) {
    invariants.close(i, devices[i]->totals());
    course.report["devices"].push_back(devices[i]->report());
    const Problems& failures = devices[i]->failures();
    course.failures.insert(course.failures.end(), failures.begin(), failures.end());
  }
  course.violations = invariants.violations();
  return course;
}

}  // namespace takt::simulation
