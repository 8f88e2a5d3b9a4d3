// The parts of a simulated device: a module under supervision, and an executor with its strands.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <takt/executor/body.hpp>
#include "device.hpp"

namespace takt::simulation {

/// What the executor calls of a thread module.
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
  Member(Device& device, const World& world, const model::Device& on, std::uint32_t i,
         channel::ModuleBlock& b)
      : model(on.modules[i]),
        index(i),
        block(b),
        recovery({.attempts = model.recovery.attempts, .backoff = model.recovery.backoff}),
        draws(world.seed, on.name + "." + model.name),
        run_time(world.cell, on, model, world.profile),
        contract(model::contract_of(on, model)),
        logical(model::timing_of(on, model) == model::Timing::let),
        body(device, *this) {}

  [[nodiscard]] bool is_thread() const noexcept { return model.type == model::ModuleType::thread; }
  [[nodiscard]] bool is_process() const noexcept { return !is_thread(); }
  [[nodiscard]] bool scheduled() const noexcept { return model.operation != model::Operation::non_real; }
  [[nodiscard]] bool sporadic() const noexcept { return model.operation == model::Operation::sporadic; }
  [[nodiscard]] lifecycle::State state() const noexcept { return machine.state(); }
  [[nodiscard]] bool in_tables() const noexcept { return block.in_tables.load() != 0; }
  /// What a run that was released then reads is as of this instant, and has it as its stamp.
  [[nodiscard]] Instant as_of(Instant release, Instant start) const noexcept {
    return logical ? release : start;
  }

  const model::Module& model;
  std::uint32_t index;
  std::uint32_t executor = 0;
  channel::ModuleBlock& block;
  lifecycle::Machine machine;
  lifecycle::Recovery recovery;
  channel::Removal removal;
  Draws draws;
  RunTime run_time;
  model::OverrunContract contract;
  bool logical;  ///< timing="let"
  ThreadBody body;

  // As its supervisor sees it.
  bool lost = false;    ///< no hook of it can be called any more
  bool failed = false;  ///< given up after an error
  bool stale = false;   ///< it is in RECOVER because an input was stale
  std::string why;
  std::uint64_t errors = 0;  ///< that the executor did not see
  std::uint64_t seen_cycles = 0;
  std::uint64_t seen_late = 0;
  std::optional<channel::Doing> pending;
  bool said_in_tables = false;  ///< what was last heard of it
  Instant put_in_at{};

  // What is to go wrong.
  Nanoseconds late_by{};
  bool to_crash = false;
  bool to_fail = false;
  bool to_hang = false;
  std::uint64_t unmended = 0;

  // Its work.
  struct Input {
    Wire* wire;
    bool event;
    bool late = false;
    channel::LinkReader reader{};
  };
  struct Output {
    Wire* wire;
    channel::LinkWriter writer{};
  };
  std::vector<Input> inputs;
  std::vector<Output> outputs;
  std::uint64_t entered = 0;  ///< the block's, at the last run()
  Instant watched_since{};

  // A program's.
  std::unique_ptr<channel::ReleaseSlot> slot;
  Strand* program = nullptr;
  bool alive = false;    ///< as far as its supervisor knows
  bool on_bell = false;  ///< it sleeps there
  bool spins = false;    ///< it sees its release at once
  bool started_again = false;
  bool killed_for_hanging = false;
  Instant told_to_end{};
  std::uint64_t said_released = 0;
  std::uint64_t said_overruns = 0;
};

struct Device::Row {
  const schedule::ExecutorPlan& plan;
  std::uint32_t index;
  Draws draws;
  std::unique_ptr<executor::Executor> executor;
  Strand* rows = nullptr;
  Strand* sporadic = nullptr;
  bool sporadic_on_bell = false;
  bool halted = true;
  Nanoseconds oversleep{};
  std::vector<std::uint32_t> in_priority{};  ///< programs, in the order in which a row releases them
};

}  // namespace takt::simulation
