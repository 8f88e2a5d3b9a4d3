// Simulates a device nanosecond by nanosecond: CPUs, SCHED_FIFO threads, rows, sporadic threads, and the
// programs of process modules. The simulation is deliberately slow and simple, and shares no code with the
// analysis that it checks.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <takt/model/cell.hpp>
#include <takt/schedule/levels.hpp>
#include <takt/schedule/placement.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::schedule::simulated {

using Tick = std::int64_t;
using Random = std::mt19937;

/// The choices by which two simulations of one device differ.
struct Phasing {
  double longest = 1;      ///< fraction of the runs that take the longest run time; other runs are shorter
  double ready = 1;        ///< probability that a sporadic module is released when this is allowed
  Tick sporadic_from = 0;  ///< the first time at which a sporadic module may be released
  /// Fraction of the wake-ups before which a thread spins as long as it may. Before the other wake-ups, the
  /// thread spins for a shorter time.
  double spin = 1;
};

struct Outcome {
  std::vector<std::optional<Tick>> response;  ///< the longest response time of each module
  /// For each module: true if it was late, skipped, or still running when it was due again.
  std::vector<bool> missed;
  [[nodiscard]] bool any_missed() const {
    return std::find(missed.begin(), missed.end(), true) != missed.end();
  }
};

class Machine;

class Thread {
 public:
  Thread(Machine& machine, int its_priority, std::vector<int> its_cpus)
      : priority(its_priority), cpus(std::move(its_cpus)), machine_(machine) {}
  virtual ~Thread() = default;
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;

  /// The machine calls this function while the thread has a CPU. Does everything that takes no time. Returns
  /// true if the thread uses the CPU for the next nanosecond.
  virtual bool advance() = 0;
  /// The machine calls this function after the thread has used a CPU for a nanosecond.
  virtual void use() = 0;
  /// The machine calls this function in each nanosecond. Models external events, which may wake the thread.
  virtual void happen() {}
  /// Records a miss for each module whose deadline has passed before its work was done.
  virtual void judge() const {}
  void wake();

  const int priority;
  const std::vector<int> cpus;
  bool ready = true;
  Tick wake_at = 0;        ///< the time at which the thread wakes up; valid while it sleeps
  std::uint64_t turn = 0;  ///< the position in the order in which threads became ready

 protected:
  bool sleep(Tick until = std::numeric_limits<Tick>::max()) {
    ready = false;
    wake_at = until;
    return false;
  }
  Machine& machine_;
};

class Program;

class Machine {
 public:
  Machine(const model::Device& device, const DevicePlan& plan, const Placement& placement,
          const std::vector<std::optional<Nanoseconds>>& runs, const Phasing& phasing, Random& random);

  Outcome run(Tick length, bool stop_at_miss);

  [[nodiscard]] const model::Module& module(std::uint32_t index) const { return device_.modules[index]; }
  [[nodiscard]] Tick now() const { return now_; }
  [[nodiscard]] std::uint64_t next_turn() {
    changed();
    return ++turn_;
  }
  /// Makes a program sleep until a body of any other program ends.
  void wait_for_turn(Program& program) { waiting_.push_back(&program); }
  void end_of_body();
  /// Threads call this function after an action that other threads may see at once.
  void changed() { changed_ = true; }
  [[nodiscard]] bool chance(double share) {
    return share >= 1 || std::bernoulli_distribution{share}(random_);
  }
  /// Returns a random time between `least` and `most`. Returns exactly `most` with probability `longest`.
  [[nodiscard]] Tick up_to(Tick least, Tick most, double longest) {
    return chance(longest) ? most : std::uniform_int_distribution<Tick>{least, most}(random_);
  }
  [[nodiscard]] Tick a_run(std::uint32_t index) { return up_to(1, runs_[index]->count(), phasing_.longest); }
  [[nodiscard]] Tick a_margin(Tick cap) { return up_to(0, cap, phasing_.spin); }
  [[nodiscard]] bool occasion() { return now_ >= phasing_.sporadic_from && chance(phasing_.ready); }
  [[nodiscard]] Program* program(std::uint32_t index) const { return programs_[index]; }

  void done(std::uint32_t index, Tick release) {
    auto& longest = outcome_.response[index];
    longest = std::max(longest.value_or(0), now_ - release);
    if (now_ - release > allowed(index)) miss(index);
  }
  void miss(std::uint32_t index) { outcome_.missed[index] = true; }
  [[nodiscard]] Tick allowed(std::uint32_t index) const {
    const model::Module& m = module(index);
    return (m.operation == model::Operation::periodic ? *m.period : *m.deadline).count();
  }

 private:
  void assign();

  const model::Device& device_;
  const std::vector<std::optional<Nanoseconds>>& runs_;
  const Phasing& phasing_;
  Random& random_;
  Tick now_ = 0;
  std::uint64_t turn_ = 0;
  bool changed_ = false;
  int cpus_ = 0;
  std::vector<std::unique_ptr<Thread>> threads_;
  std::vector<Program*> programs_;  // indexed by module
  std::vector<Program*> waiting_;
  std::vector<Thread*> on_;         // indexed by CPU
  Outcome outcome_;
};

inline void Thread::wake() {
  if (ready) return;
  ready = true;
  turn = machine_.next_turn();
}

/// The program of a process module, which uses libtakt_process.
class Program : public Thread {
 public:
  Program(Machine& machine, int its_priority, std::vector<int> its_cpus, std::uint32_t index, Tick period,
          Tick cap)
      : Thread(machine, its_priority, std::move(its_cpus)), index_(index), period_(period), cap_(cap) {}

  [[nodiscard]] bool in_body() const { return released_; }
  [[nodiscard]] bool stays() const { return cpus.size() == 1; }
  /// A row calls this function to release the program. Returns true if the program sleeps on its wake word,
  /// so that the row must wake it. `before` is the program whose body must begin first, or null.
  bool release(Tick release, const Program* before = nullptr) {
    released_ = true;
    release_ = release;
    before_ = before;
    machine_.changed();
    return on_wake_word_;
  }
  void ring() {
    on_wake_word_ = false;
    wake();
  }
  void judge() const override {
    if (released_ && machine_.now() - release_ > machine_.allowed(index_)) machine_.miss(index_);
  }

  bool advance() override {
    const model::Module& m = machine_.module(index_);
    if (released_ && left_ > 0) return true;
    if (waits_) {
      waits_ = false;
      expected_ = release_at_end_ + period_;
      spins_ = !released_ && m.dispatch == model::Dispatch::row;
      const Tick wake = expected_ - machine_.a_margin(cap_);
      if (spins_ && machine_.now() < wake) return sleep(wake);
    }
    if (!released_ && m.dispatch == model::Dispatch::immediate) {
      const Tick not_before = served_ ? release_ + m.interarrival->count() : 0;
      if (machine_.now() < not_before) return sleep(not_before);
      if (!machine_.occasion()) return sleep(machine_.now() + 1);
      release(machine_.now());
    }
    if (!released_ && spins_ && machine_.now() < expected_ + cap_) return true;
    spins_ = false;
    if (!released_) {
      on_wake_word_ = true;
      return sleep();
    }
    if (before_ != nullptr && before_->released_ && !before_->begun_ && before_->release_ == release_) {
      machine_.wait_for_turn(*this);
      return sleep();
    }
    begun_ = true;
    left_ = machine_.a_run(index_);
    return true;
  }
  void use() override {
    if (!begun_ || --left_ > 0) return;
    machine_.done(index_, release_);
    release_at_end_ = release_;
    released_ = begun_ = false;
    served_ = waits_ = true;
    machine_.end_of_body();
  }

 private:
  std::uint32_t index_;
  Tick period_;
  Tick cap_;
  Tick release_ = 0;
  Tick release_at_end_ = 0;
  Tick expected_ = 0;
  Tick left_ = 0;
  bool released_ = false;
  bool begun_ = false;
  bool served_ = false;
  bool waits_ = false;
  bool spins_ = false;
  bool on_wake_word_ = false;
  const Program* before_ = nullptr;
};

inline void Machine::end_of_body() {
  for (Program* program : std::exchange(waiting_, {})) program->wake();
}

/// The thread that runs the sporadic thread modules of an executor.
class Sporadics : public Thread {
 public:
  struct One {
    std::uint32_t index;
    bool ready = false;
    bool news = false;
    Tick release = 0;
    Tick not_before = 0;
  };
  Sporadics(Machine& machine, int its_priority, std::vector<int> its_cpus)
      : Thread(machine, its_priority, std::move(its_cpus)) {}

  std::vector<One> all;

  bool advance() override {
    if (left_ > 0) return true;
    for (One& one : all) {
      if (one.ready || !one.news || machine_.now() < one.not_before) continue;
      one.news = false;
      make_ready(one, machine_.now());
    }
    for (One& one : all) {
      if (!one.ready) continue;
      if (current_ == nullptr || deadline(one) < deadline(*current_)) current_ = &one;
    }
    if (current_ == nullptr) return sleep();
    left_ = machine_.a_run(current_->index);
    return true;
  }
  void use() override {
    if (--left_ > 0) return;
    machine_.done(current_->index, current_->release);
    current_->ready = false;
    current_ = nullptr;
  }

  void make_ready(One& one, Tick release) {
    one.ready = true;
    one.release = release;
    one.not_before = release + machine_.module(one.index).interarrival.value_or(Nanoseconds{}).count();
  }
  /// Models the arrival of a sample at a module with immediate dispatch.
  void happen() override {
    for (One& one : all) {
      if (machine_.module(one.index).dispatch != model::Dispatch::immediate) continue;
      if (!one.news && machine_.occasion()) one.news = true;
      if (one.news && !one.ready && machine_.now() >= one.not_before) wake();
    }
  }
  void judge() const override {
    for (const One& one : all) {
      if (one.ready && machine_.now() - one.release > machine_.allowed(one.index)) machine_.miss(one.index);
    }
  }

 private:
  [[nodiscard]] Tick deadline(const One& one) const { return one.release + machine_.allowed(one.index); }
  One* current_ = nullptr;
  Tick left_ = 0;
};

class Rows : public Thread {
 public:
  Rows(Machine& machine, const model::Executor& settings, const ExecutorPlan& plan, std::vector<int> its_cpus,
       Sporadics* sporadics)
      : Thread(machine, plan.priority, std::move(its_cpus)),
        settings_(settings),
        plan_(plan),
        sporadics_(sporadics),
        basic_(plan.basic_period.count()),
        not_before_(plan.sporadic.size()) {}

  bool advance() override {
    while (true) {
      if (left_ > 0) return true;
      if (!in_row_) {
        if (machine_.now() < release_) {
          if (settings_.wakeup == model::Wakeup::spin || awake_) return true;
          const Tick cap = settings_.wakeup == model::Wakeup::sleep
                               ? 0
                               : static_cast<Tick>(static_cast<double>(basic_) * settings_.spin_share);
          awake_ = true;
          const Tick until = release_ - machine_.a_margin(cap);
          if (machine_.now() < until) return sleep(until);
          continue;
        }
        awake_ = false;
        while (machine_.now() - release_ >= basic_) {
          for (const auto index : plan_.row(row_)) machine_.miss(index);
          next();
        }
        in_row_ = true;
        due_ = plan_.row(row_);
        place_ = 0;
        before_ = nullptr;
      }
      if (place_ < due_.size()) {
        step(due_[place_]);
        continue;
      }
      check_conditions();
      for (Program* program : to_wake_) program->ring();
      to_wake_.clear();
      in_row_ = false;
      next();
    }
  }
  void use() override {
    if (left_ > 0 && --left_ == 0) machine_.done(due_[place_++], release_);
  }
  /// Records missed deadlines of the modules in the current row. If no row has begun, checks the next row.
  void judge() const override {
    const std::vector<std::uint32_t> row = in_row_ ? due_ : plan_.row(row_);
    for (std::size_t i = in_row_ ? place_ : 0; i < row.size(); ++i) {
      if (machine_.now() - release_ > machine_.allowed(row[i])) machine_.miss(row[i]);
    }
  }

 private:
  void next() {
    row_ = (row_ + 1) % plan_.rows();
    release_ += basic_;
  }
  void step(std::uint32_t index) {
    if (machine_.module(index).type == model::ModuleType::thread) {
      left_ = machine_.a_run(index);
      return;
    }
    ++place_;
    Program& program = *machine_.program(index);
    if (program.in_body()) {
      machine_.miss(index);
      return;
    }
    if (program.release(release_, program.stays() ? before_ : nullptr)) to_wake_.push_back(&program);
    before_ = &program;
  }
  void check_conditions() {
    for (std::size_t i = 0; i < plan_.sporadic.size(); ++i) {
      const auto index = plan_.sporadic[i];
      const model::Module& m = machine_.module(index);
      if (m.dispatch == model::Dispatch::immediate) continue;
      if (m.type == model::ModuleType::process) {
        Program& program = *machine_.program(index);
        if (release_ < not_before_[i] || program.in_body() || !machine_.occasion()) continue;
        not_before_[i] = release_ + m.interarrival.value_or(Nanoseconds{}).count();
        if (program.release(release_)) to_wake_.push_back(&program);
        continue;
      }
      auto& one = *std::find_if(sporadics_->all.begin(), sporadics_->all.end(),
                                [index](const auto& candidate) { return candidate.index == index; });
      if (one.ready || release_ < one.not_before || !machine_.occasion()) continue;
      sporadics_->make_ready(one, release_);
      sporadics_->wake();
    }
  }

  const model::Executor& settings_;
  const ExecutorPlan& plan_;
  Sporadics* sporadics_;
  Tick basic_;
  std::vector<Tick> not_before_;
  std::size_t row_ = 0;
  Tick release_ = 0;
  bool awake_ = false;
  bool in_row_ = false;
  Tick left_ = 0;
  std::vector<std::uint32_t> due_;
  std::size_t place_ = 0;
  const Program* before_ = nullptr;  // the program that this row released last
  std::vector<Program*> to_wake_;
};

inline Machine::Machine(const model::Device& device, const DevicePlan& plan, const Placement& placement,
                        const std::vector<std::optional<Nanoseconds>>& runs, const Phasing& phasing,
                        Random& random)
    : device_(device), runs_(runs), phasing_(phasing), random_(random), programs_(device.modules.size()) {
  outcome_.response.resize(device.modules.size());
  outcome_.missed.resize(device.modules.size());
  const auto count_cpus = [this](const std::vector<int>& cpus) {
    for (const int cpu : cpus) cpus_ = std::max(cpus_, cpu + 1);
  };
  count_cpus(placement.background);
  std::ptrdiff_t programs = 0;
  for (const model::Module& m : device.modules)
    programs += m.type == model::ModuleType::process && m.operation != model::Operation::non_real;
  const auto shared = static_cast<std::ptrdiff_t>(placement.background.size());
  const Tick share = std::max<std::ptrdiff_t>(1, (programs + shared - 1) / shared);
  for (const ExecutorPlan& executor : plan.executors) {
    if (executor.rows() == 0) continue;
    const model::Executor& settings = device.executors[executor.executor];
    const std::vector<int>& cpus = placement.executors[executor.executor];
    count_cpus(cpus);
    auto sporadics = std::make_unique<Sporadics>(*this, sporadic_level(executor.priority), cpus);
    const auto add_program = [&](std::uint32_t index, Tick period) {
      const auto cap = static_cast<Tick>(static_cast<double>(period) * settings.spin_share) / share;
      auto program = std::make_unique<Program>(*this, program_level(device, executor, index),
                                               placement.background, index, period, cap);
      programs_[index] = program.get();
      threads_.push_back(std::move(program));
    };
    for (const auto index : executor.sporadic) {
      if (module(index).type == model::ModuleType::thread) {
        sporadics->all.push_back({.index = index});
      } else {
        add_program(index, executor.basic_period.count());
      }
    }
    for (const auto index : executor.periodic) {
      if (module(index).type == model::ModuleType::process)
        add_program(index, module(index).period->count());
    }
    threads_.push_back(std::make_unique<Rows>(*this, settings, executor, cpus, sporadics.get()));
    threads_.push_back(std::move(sporadics));
  }
  std::shuffle(threads_.begin(), threads_.end(), random_);
  for (auto& thread : threads_) thread->turn = next_turn();
}

// Assigns CPUs to threads in the order of their priority, and for equal priorities in the order in which they
// became ready. Each thread gets a free CPU that it may use, if there is one.
inline void Machine::assign() {
  std::vector<Thread*> ready;
  for (const auto& thread : threads_) {
    if (thread->ready) ready.push_back(thread.get());
  }
  std::sort(ready.begin(), ready.end(), [](const Thread* a, const Thread* b) {
    return a->priority != b->priority ? a->priority > b->priority : a->turn < b->turn;
  });
  std::vector<Thread*> on(static_cast<std::size_t>(cpus_), nullptr);
  for (Thread* thread : ready) {
    std::vector<int> free;
    for (const int cpu : thread->cpus) {
      if (on[static_cast<std::size_t>(cpu)] == nullptr) free.push_back(cpu);
    }
    if (free.empty()) continue;
    // A thread stays on the CPU that it used before, if this CPU is free.
    int chosen = free.size() == 1
                     ? free[0]
                     : free[std::uniform_int_distribution<std::size_t>{0, free.size() - 1}(random_)];
    for (const int cpu : free) {
      if (on_[static_cast<std::size_t>(cpu)] == thread) chosen = cpu;
    }
    on[static_cast<std::size_t>(chosen)] = thread;
  }
  on_ = std::move(on);
}

inline Outcome Machine::run(Tick length, bool stop_at_miss) {
  on_.assign(static_cast<std::size_t>(cpus_), nullptr);
  while (now_ < length) {
    for (const auto& thread : threads_) {
      if (!thread->ready && thread->wake_at <= now_) thread->wake();
      thread->happen();
    }
    // Some actions of threads take no time, but let another thread continue or make a thread wait. So this
    // loop repeats until nothing changes.
    bool settled = false;
    while (!settled) {
      settled = true;
      assign();
      for (Thread* thread : on_) {
        if (thread == nullptr) continue;
        changed_ = false;
        settled = thread->advance() && !changed_;
        if (!settled) break;
      }
    }
    ++now_;
    for (Thread* thread : on_) {
      if (thread != nullptr) thread->use();
    }
    for (const auto& thread : threads_) thread->judge();
    if (stop_at_miss && outcome_.any_missed()) break;
  }
  return outcome_;
}

}  // namespace takt::schedule::simulated
