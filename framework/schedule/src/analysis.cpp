#include <takt/schedule/analysis.hpp>

#include <algorithm>
#include <cmath>
#include <deque>

#include <takt/core/check.hpp>
#include <takt/core/words.hpp>
#include <takt/schedule/levels.hpp>
#include "contender.hpp"

namespace takt::schedule {

namespace {

using model::Device;
using model::Dispatch;
using model::Module;
using model::ModuleType;
using model::Operation;
using model::Wakeup;

// The maximum number of steps of settle(), which gives up without a result after these steps.
constexpr int kMaxIterations = 100'000;
/// The number of rounds that compute the bounds of threads with a lower priority than the rows. Each round
/// uses the bounds that the previous round found.
constexpr int kRounds = 3;
/// The maximum number of table entries that the analysis visits for an executor that other threads interrupt.
constexpr std::size_t kMaxVisited = 5'000'000;
/// The maximum time that a thread spins before a release, regardless of its period (see os::margin_cap).
constexpr Nanoseconds kLongestSpin = std::chrono::microseconds{100};

constexpr const char* kOverload = "the work does not fit into the available time";
constexpr const char* kSkipped = "its row may begin a whole basic period late and is then skipped";
constexpr const char* kUnlimited = "the minimum time between its releases is not known";
constexpr const char* kTooLong =
    "the table is too long to be analysed together with other threads on its CPU";

Nanoseconds longest_spin(Nanoseconds period, double share) {
  const double spin = std::ceil(static_cast<double>(period.count()) * share);
  return spin < static_cast<double>(kLongestSpin.count()) ? Nanoseconds{static_cast<std::int64_t>(spin)}
                                                          : kLongestSpin;
}

/// Finds the shortest time window that is long enough for the work `own` of a thread and for the work
/// `before(window)` of other threads. The window is at least `least` long. Returns the length of the window,
/// or nothing if there is no such window. If `coarse` is true, the search takes larger steps, and the result
/// may be too long by a thousandth.
template <class Before>
std::optional<Wide> settle(Wide own, Wide least, const Before& before, bool coarse = false) {
  Wide window = std::max(own, least);
  for (int step = 0; step < kMaxIterations && window < kForever; ++step) {
    const Wide next = own + before(window);
    if (next <= window) return window;
    window = coarse ? std::max(next, window + window / 1024) : next;
  }
  return std::nullopt;
}

/// A process module, with the executor whose rows release it.
struct Program {
  Contender* self = nullptr;
  const ExecutorPlan* plan = nullptr;
  std::uint32_t module = 0;
  Wide delay = 0;  ///< maximum time from the module's release until the module may run
  Wide spin = 0;   ///< maximum time that the module spins before its release
};

/// An executor with its threads: one for the rows and one for its sporadic modules.
struct Served {
  const ExecutorPlan* plan = nullptr;
  Contender* rows = nullptr;
  Contender* sporadic = nullptr;  ///< the thread of the sporadic thread modules; null if the executor has
                                  ///< none
  std::vector<Wide> ends{};  ///< for each row, the latest end, counted from the row's release; kForever if it
                             ///< has no bound
};

class Analyst {
 public:
  Analyst(const Device& device, const DevicePlan& plan, const Placement& placement,
          const std::vector<std::optional<Nanoseconds>>& runs)
      : device_(device), plan_(plan), placement_(placement), runs_(runs), worst_(device.modules.size()) {}

  std::vector<WorstCase> solve();

 private:
  void add_rows(const ExecutorPlan& plan);
  void add_sporadic(Served& served);
  void add_programs(const Served& served);

  void walk(Served& served);
  void walk_alone(Served& served);
  void walk_interrupted(Served& served);
  /// Examines one interval in which the CPU is always busy, and which begins with this row. If the interval
  /// has no bound, returns false and sets `why` to the reason.
  bool walk_stretch(Served& served, std::size_t first, std::size_t& visited, const char*& why);
  void serve_sporadic(const Served& served, std::uint32_t module, Recurring& job);
  void run_program(const Program& program);

  [[nodiscard]] const model::Executor& executor(const ExecutorPlan& plan) const {
    return device_.executors[plan.executor];
  }
  [[nodiscard]] const std::vector<int>& cpus_of(const ExecutorPlan& plan) const {
    return placement_.executors[plan.executor];
  }
  [[nodiscard]] const Module& module(std::uint32_t index) const { return device_.modules[index]; }
  [[nodiscard]] Wide run(std::uint32_t index) const { return runs_[index]->count(); }
  [[nodiscard]] bool is_thread(std::uint32_t index) const { return module(index).type == ModuleType::thread; }

  [[nodiscard]] Wide apart(const ExecutorPlan& plan, const Module& module) const;
  /// Returns an executor that never sleeps and therefore leaves no time for `self` on this CPU. Returns null
  /// if there is none.
  [[nodiscard]] const Contender* starves(const Contender& self, int cpu) const;
  [[nodiscard]] bool is_alone(const Contender& self) const;
  [[nodiscard]] Wide taken_by_others(const Contender& self, Wide window) const;
  [[nodiscard]] Wide taken_of_all(const Program& program, const std::vector<int>& cpus, Wide window) const;
  [[nodiscard]] Wide taken_by_peers(const ExecutorPlan& plan, std::uint32_t sporadic, Wide window) const;

  void set(std::uint32_t module, Wide response);
  /// Records a response time of the module, unless a longer one is already recorded.
  void note(std::uint32_t module, Wide response);
  void note(std::uint32_t module, const std::string& why);
  void give_up(Served& served, const std::string& why);

  const Device& device_;
  const DevicePlan& plan_;
  const Placement& placement_;
  const std::vector<std::optional<Nanoseconds>>& runs_;
  std::deque<Contender> contenders_;  // a deque, because pointers to its elements must remain valid
  std::vector<Served> served_;        // sorted by priority, highest first
  std::vector<Program> programs_;
  std::vector<WorstCase> worst_;  // indexed by module number
};

// ---- the contenders

void Analyst::add_rows(const ExecutorPlan& plan) {
  TAKT_CHECK(cpus_of(plan).size() == 1);
  const model::Executor& settings = executor(plan);
  std::vector<Wide> work(plan.rows());
  if (!plan.periodic.empty()) {
    for (std::size_t row = 0; row < work.size(); ++row) {
      for (const auto task : plan.table.row(row)) {
        const auto index = plan.periodic[task];
        if (is_thread(index)) work[row] += run(index);
      }
    }
  }
  const bool sleeps = settings.wakeup == Wakeup::sleep;
  const Nanoseconds spin = sleeps ? Nanoseconds{} : longest_spin(plan.basic_period, settings.spin_share);
  Contender rows{.kind = Contender::Kind::rows, .priority = plan.priority, .cpus = cpus_of(plan)};
  rows.never_sleeps = settings.wakeup == Wakeup::spin;
  rows.rows = RowDemand{std::move(work), plan.basic_period, spin};
  contenders_.push_back(std::move(rows));
  served_.push_back({.plan = &plan, .rows = &contenders_.back()});
}

/// The minimum time between two releases of the module. If the executor's rows release the module, there is
/// at most one release per row.
Wide Analyst::apart(const ExecutorPlan& plan, const Module& module) const {
  const Wide interarrival = module.interarrival.value_or(Nanoseconds{}).count();
  if (module.dispatch == Dispatch::immediate) return interarrival;
  const Wide basic = plan.basic_period.count();
  return std::max<Wide>(1, (interarrival + basic - 1) / basic) * basic;
}

void Analyst::add_sporadic(Served& served) {
  Contender sporadic{.kind = Contender::Kind::sporadic,
                     .priority = sporadic_level(served.plan->priority),
                     .cpus = cpus_of(*served.plan)};
  for (const auto index : served.plan->sporadic) {
    if (!is_thread(index)) continue;
    const Wide apart_by = apart(*served.plan, module(index));
    sporadic.jobs.push_back({.work = run(index),
                             .apart = apart_by,
                             .jitter = 0,
                             .response = std::min<Wide>(module(index).deadline->count(), apart_by)});
  }
  if (sporadic.jobs.empty()) return;
  contenders_.push_back(std::move(sporadic));
  served.sporadic = &contenders_.back();
}

// Adds the process modules that the executor releases. A process module that spins starts when the executor
// reaches the module's position in the row; a module that sleeps is woken at the end of the row.
void Analyst::add_programs(const Served& served) {
  const ExecutorPlan& plan = *served.plan;
  const auto add = [&](std::uint32_t index, Wide delay) {
    const Module& m = module(index);
    const bool periodic = m.operation == Operation::periodic;
    const bool immediate = !periodic && m.dispatch == Dispatch::immediate;
    const Nanoseconds period = periodic ? *m.period : plan.basic_period;
    const Wide before = immediate ? 0
                                  : longest_spin(period, executor(plan).spin_share).count() /
                                        programs_on_one(device_, placement_);
    const Wide after = periodic ? std::min(before, delay) : before;
    if (immediate) delay = 0;
    Contender program{.kind = Contender::Kind::program,
                      .priority = program_level(device_, plan, index),
                      .cpus = placement_.background};
    const Wide apart_by = periodic ? m.period->count() : apart(plan, m);
    const Wide deadline = (periodic ? *m.period : *m.deadline).count();
    program.jobs.push_back({.work = run(index) + before + after,
                            .apart = apart_by,
                            .jitter = delay + before,
                            .response = std::min(deadline, apart_by) + before});
    contenders_.push_back(std::move(program));
    programs_.push_back(
        {.self = &contenders_.back(), .plan = &plan, .module = index, .delay = delay, .spin = before});
  };

  std::vector<Wide> latest(device_.modules.size());
  if (!plan.periodic.empty()) {
    for (std::size_t row = 0; row < plan.rows(); ++row) {
      for (const auto task : plan.table.row(row)) {
        Wide& delay = latest[plan.periodic[task]];
        delay = std::max(delay, served.ends[row]);
      }
    }
  }
  for (const auto index : plan.periodic) {
    if (!is_thread(index)) add(index, latest[index]);
  }
  const Wide of_any = *std::max_element(served.ends.begin(), served.ends.end());
  for (const auto index : plan.sporadic) {
    if (!is_thread(index)) add(index, of_any);
  }
}

// ---- the CPU time that threads take from each other

const Contender* Analyst::starves(const Contender& self, int cpu) const {
  for (const Contender& other : contenders_) {
    if (&other != &self && other.never_sleeps && other.priority >= self.priority && other.may_run_on(cpu))
      return &other;
  }
  return nullptr;
}

bool Analyst::is_alone(const Contender& self) const {
  return std::none_of(contenders_.begin(), contenders_.end(), [&](const Contender& other) {
    return &other != &self && other.priority >= self.priority && other.may_run_on(self.cpus.front());
  });
}

// The time that other threads take from `self` on the only CPU of `self`. When the window begins, no thread
// of higher priority that has only this CPU is waiting, so only new work of these threads counts. Two kinds
// of threads may also have unfinished work from an earlier release: threads with several CPUs, and threads of
// equal priority. A process module that waits for its turn lets threads of equal priority run first, even if
// these threads were released later. If `self` is a thread of rows, threads of equal priority count like
// those of higher priority, because none of them is waiting when the window begins, either.
Wide Analyst::taken_by_others(const Contender& self, Wide window) const {
  Wide taken = 0;
  for (const Contender& other : contenders_) {
    if (&other == &self || other.priority < self.priority || !other.may_run_on(self.cpus.front())) continue;
    const bool above = other.priority > self.priority || self.kind == Contender::Kind::rows;
    taken += other.stays() && above ? other.fresh(window) : other.carried(window);
  }
  return taken;
}

// The time that other threads take from a process module that may run on any of these CPUs. The module waits
// only while threads of equal or higher priority occupy all of the CPUs.
Wide Analyst::taken_of_all(const Program& program, const std::vector<int>& cpus, Wide window) const {
  const Contender& self = *program.self;
  Wide taken = 0;
  for (const Contender& other : contenders_) {
    if (&other == &self || other.priority < self.priority) continue;
    const bool meets = std::any_of(cpus.begin(), cpus.end(), [&](int cpu) { return other.may_run_on(cpu); });
    if (meets) taken += std::min(other.carried(window), window - run(program.module) + 1);
  }
  return taken / static_cast<Wide>(cpus.size());
}

// The time that a sporadic module waits for other sporadic modules of its executor (its peers). These modules
// do not interrupt each other. A module waits for one run of each peer that is ready or running, and for
// later runs with an earlier deadline. Some peers always end so long before their deadline that, until they
// end, their deadline is later than that of this module. Such a peer counts only if it is already running,
// and only one peer can be running.
Wide Analyst::taken_by_peers(const ExecutorPlan& plan, std::uint32_t sporadic, Wide window) const {
  const Module& self = module(sporadic);
  Wide taken = 0;
  Wide longest = 0;
  Wide running = 0;
  for (const auto index : plan.sporadic) {
    if (index == sporadic || !is_thread(index)) continue;
    const Module& peer = module(index);
    longest = std::max(longest, run(index));
    const WorstCase& found = worst_[index];
    if (found.response && found.why.empty() && *found.response <= *peer.deadline - *self.deadline) {
      running = std::max(running, run(index));
      continue;
    }
    const Wide earlier = std::min<Wide>((*self.deadline - *peer.deadline).count(), window);
    const Recurring later{.work = run(index), .apart = apart(plan, peer)};
    taken += run(index) + (earlier > 0 ? later.fresh(earlier) : 0);
  }
  taken += running;
  // For a module with immediate dispatch, events are checked only between two runs. So the module may also
  // have to wait for one whole run.
  return taken + (self.dispatch == Dispatch::immediate ? longest : 0);
}

// ---- rows

void Analyst::walk(Served& served) {
  const ExecutorPlan& plan = *served.plan;
  served.ends.assign(plan.rows(), 0);
  if (const Contender* other = starves(*served.rows, served.rows->cpus.front()); other != nullptr) {
    give_up(served, "an executor that never sleeps leaves it no time on CPU " +
                        std::to_string(served.rows->cpus.front()));
  } else if (is_alone(*served.rows)) {
    walk_alone(served);
  } else {
    walk_interrupted(served);
  }
  served.rows->rows_response = *std::max_element(served.ends.begin(), served.ends.end());
}

// Simulates an executor that is alone on its CPU. The longest runs are the worst case, because a shorter run
// never delays another run. Each round simulates one macro period. If more work is left over after the second
// round than after the first, the backlog grows forever.
void Analyst::walk_alone(Served& served) {
  const ExecutorPlan& plan = *served.plan;
  const Wide basic = plan.basic_period.count();
  Wide time = 0;
  Wide release = 0;
  Wide left_over = 0;
  for (int round = 0; round < 2; ++round) {
    for (std::size_t row = 0; row < plan.rows(); ++row, release += basic) {
      time = std::max(time, release);
      const bool skipped = time - release >= basic;
      if (!plan.periodic.empty()) {
        for (const auto task : plan.table.row(row)) {
          const auto index = plan.periodic[task];
          if (skipped) note(index, kSkipped);
          if (!is_thread(index)) continue;
          time += run(index);
          note(index, time - release);
        }
      }
      served.ends[row] = std::max(served.ends[row], time - release);
    }
    const Wide now = std::max<Wide>(0, time - release);
    if (round == 1 && now > left_over) give_up(served, kOverload);
    left_over = now;
  }
}

// Examines, for each row, a busy interval that begins with this row. In such an interval the CPU is never
// free for threads of lower priority. Later rows of the interval wait for earlier ones.
void Analyst::walk_interrupted(Served& served) {
  std::size_t visited = 0;
  const char* why = kOverload;
  for (std::size_t first = 0; first < served.plan->rows(); ++first) {
    if (walk_stretch(served, first, visited, why)) continue;
    give_up(served, why);
    return;
  }
}

bool Analyst::walk_stretch(Served& served, std::size_t first, std::size_t& visited, const char*& why) {
  const ExecutorPlan& plan = *served.plan;
  const Wide basic = plan.basic_period.count();
  const auto others = [&](Wide window) { return taken_by_others(*served.rows, window); };
  const std::size_t longest = 4 * plan.rows() + 64;
  Wide own = 0;
  Wide release = 0;
  // The time at which the work of the rows so far is done, including the work of other threads before it.
  Wide done = 0;
  for (std::size_t i = 0; i < longest; ++i, release += basic) {
    const std::size_t row = (first + i) % plan.rows();
    // The latest time at which the thread may get the CPU for one more nanosecond of work.
    const auto start = settle(own + 1, done, others);
    if (!start) return false;
    if (i > 0 && done <= release) return true;
    const bool skipped = *start - 1 - release >= basic;
    if (!plan.periodic.empty()) {
      for (const auto task : plan.table.row(row)) {
        const auto index = plan.periodic[task];
        if (skipped) note(index, kSkipped);
        if (++visited > kMaxVisited) {
          why = kTooLong;
          return false;
        }
        if (!is_thread(index)) continue;
        own += run(index);
        const auto end = settle(own, done, others);
        if (!end) return false;
        done = *end;
        note(index, done - release);
      }
    }
    const auto end = settle(own + 1, done, others);
    if (!end) return false;
    served.ends[row] = std::max(served.ends[row], *end - 1 - release);
  }
  return false;
}

// ---- threads with a lower priority than the rows

void Analyst::serve_sporadic(const Served& served, std::uint32_t index, Recurring& job) {
  const Contender& self = *served.sporadic;
  const int cpu = self.cpus.front();
  if (starves(self, cpu) != nullptr) {
    note(index, "an executor that never sleeps leaves it no time on CPU " + std::to_string(cpu));
    return;
  }
  const auto response = settle(run(index), 0, [&](Wide window) {
    return taken_by_others(self, window) + taken_by_peers(*served.plan, index, window);
  });
  if (job.apart == 0) {
    note(index, kUnlimited);
  } else if (response) {
    set(index, *response);
    job.response = std::min(job.response, *response);
  } else {
    note(index, kOverload);
  }
}

void Analyst::run_program(const Program& program) {
  Contender& self = *program.self;
  std::vector<int> cpus = self.cpus;
  std::erase_if(cpus, [&](int cpu) { return starves(self, cpu) != nullptr; });
  if (cpus.empty()) {
    note(program.module, "executors that never sleep leave it no time on any of its CPUs");
    return;
  }
  // Use coarse steps: with several CPUs, the window may grow by only one nanosecond per step.
  const auto response = settle(
      run(program.module), 0,
      [&](Wide window) {
        return self.stays() ? taken_by_others(self, window) : taken_of_all(program, cpus, window);
      },
      !self.stays());
  Recurring& job = self.jobs.front();
  if (job.apart == 0) {
    note(program.module, kUnlimited);
  } else if (response && *response + program.delay < kForever) {
    const Wide found = *response + program.delay;
    set(program.module, found);
    job.response = std::min(job.response, found + program.spin);
  } else {
    note(program.module, kOverload);
  }
}

// ---- results

void Analyst::set(std::uint32_t index, Wide response) {
  if (worst_[index].why == kOverload)
    worst_[index].why.clear();  // an earlier round found no bound, but this round found one
  constexpr Wide kLargest = Nanoseconds::max().count();
  worst_[index].response = Nanoseconds{static_cast<std::int64_t>(std::min(response, kLargest))};
}

void Analyst::note(std::uint32_t index, Wide response) {
  const auto known = worst_[index].response;
  if (!known || response > known->count()) set(index, response);
}

void Analyst::note(std::uint32_t index, const std::string& why) { worst_[index].why = why; }

void Analyst::give_up(Served& served, const std::string& why) {
  std::fill(served.ends.begin(), served.ends.end(), kForever);
  for (const auto index : served.plan->periodic) {
    note(index, why);
    worst_[index].response.reset();
  }
}

std::vector<WorstCase> Analyst::solve() {
  std::vector<const ExecutorPlan*> plans;
  for (const ExecutorPlan& plan : plan_.executors) {
    if (plan.rows() != 0) plans.push_back(&plan);
  }
  std::stable_sort(plans.begin(), plans.end(),
                   [](const auto* a, const auto* b) { return a->priority > b->priority; });
  for (const ExecutorPlan* plan : plans) add_rows(*plan);
  // Analyse the executors in the order of priority, highest first, because only executors of higher priority
  // can interrupt rows.
  for (Served& served : served_) {
    walk(served);
    add_sporadic(served);
    add_programs(served);
  }
  // The first round only assumes that all deadlines are met. Later rounds use the bounds found so far.
  for (int round = 0; round < kRounds; ++round) {
    for (const Served& served : served_) {
      std::size_t job = 0;
      for (const auto index : served.plan->sporadic) {
        if (is_thread(index)) serve_sporadic(served, index, served.sporadic->jobs[job++]);
      }
    }
    for (const Program& program : programs_) run_program(program);
  }

  std::vector<WorstCase> all;
  for (std::uint32_t i = 0; i < worst_.size(); ++i) {
    const Module& m = module(i);
    if (m.operation == Operation::non_real) continue;
    WorstCase& worst = all.emplace_back(std::move(worst_[i]));
    const auto of_module = [&](const Served& served) { return executor(*served.plan).name == m.executor; };
    const auto served = std::find_if(served_.begin(), served_.end(), of_module);
    worst.module = i;
    worst.cpus = is_thread(i) ? served->rows->cpus : placement_.background;
    worst.run = *runs_[i];
    worst.deadline = m.operation == Operation::periodic ? *m.period : *m.deadline;
  }
  return all;
}

std::string reason(const WorstCase& worst) {
  if (!worst.why.empty()) return worst.why;
  return "it may finish as late as " + to_text(*worst.response) + " after its release, " +
         to_text(*worst.response - worst.deadline) + " too late";
}

}  // namespace

bool WorstCase::unknown() const { return why == kUnlimited || why == kTooLong; }

std::vector<WorstCase> worst_cases(const Device& device, const DevicePlan& plan, const Placement& placement,
                                   const std::vector<std::optional<Nanoseconds>>& runs) {
  return Analyst{device, plan, placement, runs}.solve();
}

Problems missed_deadlines(const model::Cell& cell, const Device& device,
                          const std::vector<WorstCase>& worst_cases) {
  Problems problems;
  for (const WorstCase& worst : worst_cases) {
    if (worst.kept()) continue;
    const Module& module = device.modules[worst.module];
    const bool periodic = module.operation == Operation::periodic;
    const std::string name = in_quotes(device.name + "." + module.name);
    problems.push_back(model::problem_at(
        cell.texts(), module.line,
        (worst.unknown() ? "it cannot be shown that " + name + " keeps its " : name + " cannot keep its ") +
            (periodic ? "period" : "deadline") + ", " + to_text(worst.deadline) + ": " + reason(worst),
        worst.why == kUnlimited ? "add an <interarrival>"
                                : std::string{"shorten the runs, lengthen the "} +
                                      (periodic ? "periods" : "deadlines or periods") +
                                      ", or move modules to another executor or CPU"));
  }
  return problems;
}

}  // namespace takt::schedule
