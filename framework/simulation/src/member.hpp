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
        run_time(world.cell, parts.of_device(), model, world.profile),
        contract(model::contract_of(parts.of_device(), model)),
        logical(model::timing_of(parts.of_device(), model) == model::Timing::let),
        body(device, *this) {
    if (scheduled()) executor = static_cast<std::uint32_t>(parts.executor_of(model));
  }

  [[nodiscard]] bool is_thread() const noexcept { return model.type == model::ModuleType::thread; }
  [[nodiscard]] bool scheduled() const noexcept { return model.operation != model::Operation::non_real; }
  [[nodiscard]] bool in_tables() const noexcept { return block.in_tables.load() != 0; }
  /// The logical time of a run: it reads its inputs as of this instant, and stamps its outputs with it.
  [[nodiscard]] Instant as_of(Instant release, Instant start) const noexcept {
    return logical ? release : start;
  }

  const model::Module& model;
  std::uint32_t index;
  std::uint32_t executor = 0;
  VirtualHost* host = nullptr;  ///< the host of a thread module; null for a program
  channel::ModuleBlock& block;
  channel::ReleaseSlot* slot;
  Draws draws;
  RunTime run_time;
  model::OverrunContract contract;
  bool logical;  ///< timing="let"
  ThreadBody body;
  bool reported_in_tables = false;  ///< whether it is in the tables, as the last event reported

  // Injected faults.
  Nanoseconds late_by{};
  bool to_crash = false;
  bool to_fail = false;
  bool to_hang = false;
  std::uint64_t unmended = 0;
  std::vector<Fault> in_hooks;  ///< each happens at the next call of its hook

  // The module's work.
  struct Input {
    Wire* wire;
    bool event;
    bool late = false;
    bool safe = false;  ///< whether the last read gave the safe value
    channel::LinkReader reader{};
  };
  struct Output {
    Wire* wire;
    channel::LinkWriter writer{};
  };
  std::vector<Input> inputs;
  std::vector<Output> outputs;
  std::uint64_t entered = 0;  ///< block.entered at the last run()
  Instant watched_since{};

  // The following members are used only for programs.
  VirtualProgram* process = nullptr;
  Strand* program = nullptr;
  bool on_wake_word = false;  ///< whether it sleeps on the wake word
  bool spins = false;         ///< whether it spins, and so sees its release at once
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
  std::vector<std::uint32_t> in_priority{};  ///< programs, in the order in which a row releases them
};

}  // namespace takt::simulation
