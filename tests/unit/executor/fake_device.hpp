// A device with one executor, on virtual time. Each test defines the bodies of the thread modules. A process
// module consists only of its release slot.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <takt/channel/layout.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/executor/executor.hpp>
#include <takt/model/cell.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::executor {

class VirtualClock final : public Clock {
 public:
  Instant now() noexcept override { return time; }
  Instant time = from_ns(1'000'000'000);
};

class Script final : public Body {
 public:
  Outcome run(const Cycle& cycle) noexcept override { return on_run ? on_run(cycle) : nullptr; }
  Outcome condition(const Cycle&, bool* ready) noexcept override {
    ++asked;
    return on_condition ? on_condition(ready) : nullptr;
  }

  bool has_news(Instant) const noexcept override { return on_news && on_news(); }

  std::function<const char*(const Cycle&)> on_run;
  std::function<bool()> on_news;
  std::function<const char*(bool*)> on_condition;
  int asked = 0;
};

inline model::Module periodic(model::ModuleType type, Nanoseconds period, int priority = 0) {
  model::Module module;
  module.type = type;
  module.operation = model::Operation::periodic;
  module.period = period;
  module.priority = priority;
  module.executor = "main";
  return module;
}
inline model::Module thread(Nanoseconds period, int priority = 0) {
  return periodic(model::ModuleType::thread, period, priority);
}
inline model::Module process(Nanoseconds period, int priority = 0) {
  return periodic(model::ModuleType::process, period, priority);
}
inline model::Module sporadic(model::ModuleType type, Nanoseconds deadline, int priority = 0) {
  model::Module module;
  module.type = type;
  module.operation = model::Operation::sporadic;
  module.deadline = deadline;
  module.priority = priority;
  module.executor = "main";
  return module;
}

/// An executor and all data that it uses. `blocks`, `bodies` and `slots` contain one element for each module,
/// in the order of `modules`. At first, all modules are in the tables, and all process modules wait for a
/// release.
class FakeDevice {
 public:
  explicit FakeDevice(std::vector<model::Module> modules)
      : count(modules.size()),
        block(std::make_unique<channel::ExecutorBlock>()),
        blocks(std::make_unique<channel::ModuleBlock[]>(count)),
        bodies(std::make_unique<Script[]>(count)),
        slots(std::make_unique<channel::ReleaseSlot[]>(count)) {
    model::Device device;
    device.executors.emplace_back();
    device.modules = std::move(modules);
    for (std::size_t i = 0; i < count; ++i) device.modules[i].name = "m" + std::to_string(i);
    plan = *schedule::plan(model::Cell{}, device);

    const auto select = [&](const std::vector<std::uint32_t>& indices) {
      std::vector<Unit> units;
      for (const std::uint32_t i : indices) {
        const model::Module& m = device.modules[i];
        Unit unit{.index = i,
                  .block = &blocks[i],
                  .period = m.period.value_or(Nanoseconds{0}),
                  .deadline = m.deadline.value_or(Nanoseconds{0}),
                  .budget = m.budget.value_or(Nanoseconds{0}),
                  .interarrival = m.interarrival.value_or(Nanoseconds{0}),
                  .immediate = m.dispatch == model::Dispatch::immediate,
                  .late_is_error = m.miss == model::Miss::error,
                  .overrun = model::contract_of(device, m),
                  .tolerance = m.tolerance};
        if (m.type == model::ModuleType::thread) {
          unit.body = &bodies[i];
        } else {
          unit.slot = &slots[i];
          slots[i].wake_bit = channel::wake_bit(i);
          slots[i].period_ns = unit.period.count();
          if (unit.overrun.what == model::Overrun::catch_up)
            slots[i].catch_up = static_cast<std::uint32_t>(unit.overrun.limit);
          slots[i].phase.store(channel::ReleaseSlotPhase::ready);
        }
        blocks[i].in_tables.store(1);
        units.push_back(unit);
      }
      return units;
    };
    const schedule::ExecutorPlan& mine = plan.executors[0];
    periodic_units = select(mine.periodic);
    sporadic_units = select(mine.sporadic);
    make_executor();
  }

  /// Makes a new executor, as after a restart of the host. The blocks keep their contents.
  void make_executor() {
    executor =
        std::make_unique<Executor>(plan.executors[0], periodic_units, sporadic_units, *block, clock, flight);
  }

  /// Lets the executor join the grid at the current time of the clock. T0 is `later` after this time.
  void join(Nanoseconds later = Nanoseconds{0}) {
    t0 = clock.time + later;
    executor->join_grid(t0, clock.time);
  }

  /// Advances the clock to `delay` after the next release, and runs the row.
  std::uint32_t cycle(Nanoseconds delay = Nanoseconds{0}) {
    clock.time = std::max(clock.time, executor->next_release()) + delay;
    return executor->run_cycle(clock.time);
  }

  std::size_t count;
  VirtualClock clock;
  std::unique_ptr<channel::ExecutorBlock> block;
  std::unique_ptr<channel::ModuleBlock[]> blocks;
  std::unique_ptr<Script[]> bodies;
  std::unique_ptr<channel::ReleaseSlot[]> slots;
  schedule::DevicePlan plan;
  std::vector<Unit> periodic_units;
  std::vector<Unit> sporadic_units;
  Flight flight;  ///< takes effect at the next make_executor()
  std::unique_ptr<Executor> executor;
  Instant t0{};
};

}  // namespace takt::executor
