// The parts of a simulated device: a supervised module, and an executor with its strands.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <takt/executor/body.hpp>
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
  /// The logical time of a run: it reads its inputs as of this instant, and stamps its outputs with it.
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

  // The supervisor's view of the module.
  bool lost = false;    ///< none of its hooks can be called any more
  bool failed = false;  ///< given up after an error
  bool stale = false;   ///< it is in RECOVER because an input was stale
  std::string why;
  std::uint64_t errors = 0;  ///< errors that the executor did not see
  std::uint64_t seen_cycles = 0;
  std::uint64_t seen_late = 0;
  std::optional<channel::Doing> pending;
  bool reported_in_tables = false;  ///< as the last event reported it
  Instant put_in_at{};

  // Injected faults.
  Nanoseconds late_by{};
  bool to_crash = false;
  bool to_fail = false;
  bool to_hang = false;
  std::uint64_t unmended = 0;

  // The module's work.
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
  std::uint64_t entered = 0;  ///< block.entered at the last run()
  Instant watched_since{};

  // Only for programs.
  std::unique_ptr<channel::ReleaseSlot> slot;
  Strand* program = nullptr;
  bool alive = false;         ///< as far as its supervisor knows
  bool on_wake_word = false;  ///< it sleeps on the wake word
  bool spins = false;         ///< it spins, so it sees its release at once
  bool started_again = false;
  bool killed_for_hanging = false;
  Instant end_requested_at{};
  std::uint64_t reported_releases = 0;
  std::uint64_t reported_overruns = 0;
};

struct Device::Row {
  const schedule::ExecutorPlan& plan;
  std::uint32_t index;
  Draws draws;
  std::unique_ptr<executor::Executor> executor;
  Strand* rows = nullptr;
  Strand* sporadic = nullptr;
  bool sporadic_on_wake_word = false;
  bool halted = true;
  Nanoseconds oversleep{};
  std::vector<std::uint32_t> in_priority{};  ///< programs, in the order in which a row releases them
};

}  // namespace takt::simulation
