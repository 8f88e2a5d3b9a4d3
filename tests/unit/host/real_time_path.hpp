// A device that runs in real time while the test counts every allocation, lock and system call of its
// real-time threads. The product contains no code for this: the test sets the traps from run() of a module.
#pragma once

#include <gtest/gtest.h>

#include <linux/futex.h>
#include <sys/syscall.h>

#include <array>
#include <atomic>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <takt/channel/flight_record.hpp>
#include <takt/channel/layout.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/machine.hpp>
#include <takt/schedule/plan.hpp>
#include "executor_threads.hpp"

#include "system_call_trap.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TAKT_SANITIZED 1
#else
#define TAKT_SANITIZED 0
#endif

namespace takt::host {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// The numbers of calls that the watched threads have made. watched.cpp counts them.
extern std::atomic<std::uint64_t> allocations;
extern std::atomic<std::uint64_t> frees;
extern std::atomic<std::uint64_t> locks;
extern std::atomic<std::uint64_t> waits;
/// Starts counting the calls of the thread that calls watch(). Returns false if this thread was already
/// watched.
bool watch();

class Script final : public executor::Body {
 public:
  executor::Outcome run(const Cycle& cycle) noexcept override {
    if (on_run) on_run(cycle);
    return {};
  }
  executor::Outcome condition(const Cycle&, bool* ready) noexcept override {
    *ready = ++asked % 3 == 0;
    return {};
  }
  std::function<void(const Cycle&)> on_run;
  std::uint64_t asked = 0;
};

/// A device that runs in real time with a flight recorder. It has three periodic thread modules, a sporadic
/// thread module, and a process module that sleeps on the wake word after each body.
class RealTimePath : public testing::Test {
 protected:
  static constexpr auto kPeriod = microseconds{500};
  static constexpr std::size_t kSporadic = 3;
  static constexpr std::size_t kProgram = 4;
  // Capacity of each ring of the flight record, in entries. The rings are small, so that new entries
  // overwrite old entries.
  static constexpr std::uint64_t kRecorded = 256;

  void SetUp() override {
    if (TAKT_SANITIZED != 0)
      GTEST_SKIP() << "the sanitizer's own allocator, locks and system calls would be counted";
    for (auto* counter : {&allocations, &frees, &locks, &waits}) counter->store(0);
    model::Device device;
    device.executors.emplace_back();
    for (std::size_t i = 0; i < 5; ++i) {
      model::Module module;
      module.name = "m" + std::to_string(i);
      module.executor = "main";
      module.type = i == kProgram ? model::ModuleType::process : model::ModuleType::thread;
      module.operation = i == kSporadic ? model::Operation::sporadic : model::Operation::periodic;
      if (i == kSporadic) {
        module.deadline = milliseconds{10};
      } else {
        module.period = i == 2 ? kPeriod * 3 : kPeriod;
      }
      device.modules.push_back(module);
      blocks[i].in_tables.store(1);
    }
    const auto plan = *schedule::plan(model::Cell{}, device);
    record = std::move(*channel::FlightRecord::create({kRecorded, kRecorded}));
    for (std::size_t ring = 0; ring < flight.size(); ++ring) flight[ring] = record.writer(ring);
    slot.wake_bit = channel::wake_bit(0);
    slot.phase.store(channel::ReleaseSlotPhase::ready);
    std::vector<executor::Unit> periodic;
    for (const std::uint32_t i : plan.executors[0].periodic) {
      periodic.push_back({.index = i,
                          .body = i == kProgram                   ? nullptr
                                  : replaced == nullptr || i != 1 ? &bodies[i]
                                                                  : replaced,
                          .slot = i == kProgram ? &slot : nullptr,
                          .block = &blocks[i],
                          .period = *device.modules[i].period});
    }
    std::vector<executor::Unit> sporadic{{.index = kSporadic,
                                          .body = &bodies[kSporadic],
                                          .block = &blocks[kSporadic],
                                          .deadline = milliseconds{10}}};
    threads = std::make_unique<ExecutorThreads>(device.executors[0], plan.executors[0], periodic, sporadic,
                                                *block, wake_word, executor::Flight{&flight[0], &flight[1]});
    row_trap = std::make_unique<SystemCallTrap>([this] { return block->cycles.load(); });
    sporadic_trap = std::make_unique<SystemCallTrap>([this] { return blocks[kSporadic].cycles.load(); });
    set_at_first_run(0, *row_trap);
    set_at_first_run(kSporadic, *sporadic_trap);
  }

  /// Makes the first run() of the module set the trap on the thread that calls run().
  void set_at_first_run(std::size_t module, SystemCallTrap& trap) {
    bodies[module].on_run = [this, &trap](const Cycle&) {
      if (!watch()) return;
      if (const int error = trap.arm(); error != 0) trap_error = error;
    };
  }

  /// Runs the device for this many cycles, and stores the calls that the watched threads have made by then.
  void run(std::uint64_t cycles) {
    std::thread program{[this] { serve(); }};
    Problems problems;
    const auto begun =
        threads->begin(os::now() + milliseconds{20}, {os::read_cpus().ordinary.back()}, &problems);
    EXPECT_TRUE(begun.ok());
    for (const Problem& problem : problems) GTEST_LOG_(WARNING) << to_text(problem);
    const Instant limit = os::now() + std::chrono::seconds{60};
    while (block->cycles.load() < cycles && trap_error == 0 && os::now() < limit) {
      std::this_thread::sleep_for(milliseconds{10});
    }
    row_calls = row_trap->calls();
    sporadic_calls = sporadic_trap->calls();
    seen = {{"allocations", allocations}, {"frees", frees}, {"locks", locks}, {"waits", waits}};
    threads->ask_to_halt();
    threads->join();
    slot.end.store(1);
    wake_word.rings.fetch_add(1);
    os::futex_wake(wake_word.rings, ~0U);
    program.join();
    ASSERT_EQ(trap_error, 0)
        << "this system denies seccomp user notification (" << std::strerror(trap_error)
        << "), so this test proves nothing; allow seccomp(SECCOMP_SET_MODE_FILTER) with a listener";
    ASSERT_GE(block->cycles.load(), cycles);
  }

  void serve() {
    std::uint32_t taken = 0;
    while (slot.end.load() == 0) {
      slot.done.store(taken);
      const std::uint32_t rings = wake_word.rings.load();
      slot.sleeping.store(1);
      if (slot.released.load() == taken && slot.end.load() == 0)
        os::futex_wait(wake_word.rings, rings, slot.wake_bit);
      slot.sleeping.store(0);
      taken = slot.released.load();
    }
  }

  static bool is_futex(const SystemCall& call, int operation, const void* from, std::size_t size) {
    const auto first = reinterpret_cast<std::uintptr_t>(from);
    return call.number == SYS_futex && (static_cast<int>(call.arguments[1]) & FUTEX_CMD_MASK) == operation &&
           call.arguments[0] >= first && call.arguments[0] < first + size;
  }

  std::array<Script, 5> bodies;
  executor::Body* replaced = nullptr;  // if set, runs instead of bodies[1]
  std::array<channel::ModuleBlock, 5> blocks{};
  std::unique_ptr<channel::ExecutorBlock> block = std::make_unique<channel::ExecutorBlock>();
  channel::ReleaseSlot slot{};
  channel::WakeWord wake_word{};
  channel::FlightRecord record;
  std::array<channel::FlightWriter, 2> flight;
  std::unique_ptr<SystemCallTrap> row_trap;
  std::unique_ptr<SystemCallTrap> sporadic_trap;
  // Declared after the traps, so that its destructor ends the watched threads before the traps are destroyed.
  std::unique_ptr<ExecutorThreads> threads;
  std::atomic<int> trap_error{0};
  std::vector<SystemCall> row_calls;
  std::vector<SystemCall> sporadic_calls;
  std::map<std::string, std::uint64_t> seen;
};

}  // namespace takt::host
