// The parts of a simulated device: a module's work, and an executor with its strands.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <takt/executor/body.hpp>
#include <takt/schedule/logical_time.hpp>
#include "device.hpp"

namespace takt::simulation {

/// The body that the executor calls for a thread module.
class ThreadBody final : public executor::Body {
 public:
  ThreadBody(Device& device, Device::Member& member) : device_(device), member_(member) {}
  executor::Outcome run(const Cycle& cycle) noexcept override;
  executor::Outcome condition(const Cycle& cycle, bool* ready) noexcept override;
  [[nodiscard]] bool has_news(Instant now) const noexcept override;

 private:
  Device& device_;
  Device::Member& member_;
};

struct Device::Member {
  Member(Device& device, const World& world, const supervision::Parts& parts, std::uint32_t i)
      : model(parts.of_device().modules[i]),
        index(i),
        block(parts.channel.module(i)),
        slot(parts.slot_of(i)),
        draws(world.seed, parts.of_device().name + "." + model.name),
        run_time(device.cell(), parts.of_device(), model, world.profile),
        contract(model::contract_of(parts.of_device(), model)),
        logical(model::timing_of(parts.of_device(), model) == model::Timing::let),
        body(device, *this) {
    if (scheduled()) executor = static_cast<std::uint32_t>(parts.executor_of(model));
  }

  [[nodiscard]] bool is_thread() const noexcept { return model.type == model::ModuleType::thread; }
  [[nodiscard]] bool scheduled() const noexcept { return model.operation != model::Operation::non_real; }
  [[nodiscard]] bool in_tables() const noexcept { return block.in_tables.load() != 0; }
  /// The logical time of a run: the time at which it reads its inputs, and the stamp of its outputs.
  [[nodiscard]] Instant as_of(Instant release, Instant start) const noexcept {
    return logical ? release : start;
  }

  const model::Module& model;
  std::uint32_t index;
  std::uint32_t executor = 0;
  VirtualHost* host = nullptr;  ///< the host of a thread module; null for a process module
  channel::ModuleBlock& block;
  channel::ReleaseSlot* slot;
  Draws draws;
  RunTime run_time;
  model::OverrunContract contract;
  bool logical;  ///< true for a module with timing="let"
  ThreadBody body;
  bool reported_in_tables = false;  ///< true if the last event reported that the module is in the tables

  // Injected faults.
  Nanoseconds late_by{};
  bool to_crash = false;
  bool to_fail = false;
  bool to_hang = false;
  bool to_finish = false;
  std::uint64_t unmended = 0;
  std::vector<Injection> in_hooks;  ///< faults in hooks; each fault happens at the next call of its hook

  // The module's work.
  struct Input {
    SimulatedLink* link;
    bool event;
    bool late = false;
    bool safe = false;  ///< true if the last read gave the safe value
    channel::LinkReader reader{};
  };
  struct Output {
    SimulatedLink* link;
    channel::LinkWriter writer{};
  };
  std::vector<Input> inputs;
  std::vector<Output> outputs;
  std::uint64_t entered = 0;  ///< value of block.entered at the last run()
  Instant watched_since{};

  // The following members are used only for process modules.
  VirtualProgram* process = nullptr;
  Strand* program = nullptr;
  bool on_wake_word = false;  ///< true if the process module sleeps on the wake word
  bool spins = false;         ///< true if the process module spins, so that it sees its release at once
  std::uint64_t reported_releases = 0;
  std::uint64_t reported_overruns = 0;
};

struct Device::Row {
  const schedule::ExecutorPlan& plan;
  std::uint32_t index;
  VirtualHost& host;
  Draws draws;
  std::unique_ptr<executor::Executor> executor;
  Strand* sporadic = nullptr;
  bool sporadic_on_wake_word = false;
  Nanoseconds oversleep{};
  std::vector<std::uint32_t> in_priority{};  ///< process modules, in the order in which a row releases them
};

}  // namespace takt::simulation
