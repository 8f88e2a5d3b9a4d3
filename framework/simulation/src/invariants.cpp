#include "invariants.hpp"

#include <algorithm>
#include <utility>

#include <takt/model/hosts.hpp>

namespace takt::simulation {

namespace {

/// The rows that contain a module: `first`, and every `stride` rows after it.
struct Rows {
  std::uint64_t first;
  std::uint64_t stride;
  /// The number of rows in [from, to) that contain the module.
  [[nodiscard]] std::uint64_t in(std::uint64_t from, std::uint64_t to) const {
    const auto before = [this](std::uint64_t row) {
      return row <= first ? 0 : (row - first + stride - 1) / stride;
    };
    return before(to) - before(from);
  }
};

Rows rows_of(const schedule::ExecutorPlan& plan, std::uint32_t module, Nanoseconds period) {
  return {static_cast<std::uint64_t>(schedule::offset_of(plan, module) / plan.basic_period),
          static_cast<std::uint64_t>(period / plan.basic_period)};
}

std::string number(std::uint64_t n) { return std::to_string(n); }

}  // namespace

Invariants::Invariants(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans, Instant t0)
    : t0_(t0) {
  add_version(cell, plans);
  for (std::size_t i = 0; i < cell.devices.size(); ++i) devices_.push_back(as_new(i, 0));
}

void Invariants::add_version(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans) {
  versions_.push_back({&cell, &plans, numbers_.of(cell)});
  connections_.resize(numbers_.size());
}

Invariants::OfDevice Invariants::as_new(std::size_t device, std::size_t version) const {
  const model::Device& model = versions_[version].cell->devices[device];
  return {.version = version,
          .t0 = t0_,
          .executors = std::vector<OfExecutor>(model.executors.size()),
          .modules = std::vector<OfModule>(model.modules.size())};
}

void Invariants::violated(const Event& event, const std::string& what) {
  if (violations_.size() < kMaxViolations)
    violations_.push_back(to_text(event, *versions_[event.version].cell, t0_) + ": " + what);
}

Nanoseconds Invariants::period_of(std::uint32_t device, std::uint32_t module) const {
  return *model_of(device).modules[module].period;
}

std::uint32_t Invariants::executor_of(std::uint32_t device, std::uint32_t module) const {
  const model::Device& model = model_of(device);
  const auto found = std::find_if(model.executors.begin(), model.executors.end(), [&](const auto& executor) {
    return executor.name == model.modules[module].executor;
  });
  return static_cast<std::uint32_t>(found - model.executors.begin());
}

void Invariants::on_event(const Event& event) {
  if (event.connection != Event::kNone) {
    on_sample(event);
    return;
  }
  if (event.device == Event::kNone) return;
  OfDevice& device = devices_[event.device];
  if (event.what == What::prepares) device = as_new(event.device, event.version);
  if (event.what == What::begins) device.t0 = event.release;
  if (event.executor != Event::kNone) {
    on_row(event, device);
  } else if (event.module != Event::kNone) {
    on_module(event, device);
  } else if (event.what == What::host_ended) {
    const model::HostShare host = model::hosts_of(model_of(event.device))[event.host];
    for (const std::size_t index : host.executors) {
      OfExecutor& executor = device.executors[index];
      // The end of the host cut the current row short. The row counts as missed, even for the modules that it
      // has already served.
      const Nanoseconds basic = plan_of(event.device).executors[index].basic_period;
      for (const Served& served : executor.served) {
        const bool unfinished = executor.runs == served.module && &served == &executor.served.back();
        if (!executor.in_row || unfinished) continue;
        // If the module made up for the release of an earlier row, which it had missed, this release does not
        // count as missed.
        const bool made_up = served.number && served.release + basic <= executor.woke_at;
        if (made_up)
          --device.modules[served.module].missed;
        else
          ++device.modules[served.module].twice;
      }
      executor.served.clear();  // because the restarted host may end before the executor joins its grid
      executor.runs.reset();
      executor.sporadic.reset();
    }
    for (const std::uint32_t index : host.modules) {
      OfModule& module = device.modules[index];
      module.failed = module.raised = false;
      module.ready_until.reset();
      module.last_ready.reset();
    }
  }
}

void Invariants::on_row(const Event& event, OfDevice& device) {
  OfExecutor& executor = device.executors[event.executor];
  const schedule::ExecutorPlan& plan = plan_of(event.device).executors[event.executor];
  const Nanoseconds basic = plan.basic_period;
  const auto due = [&](std::uint64_t row) { return device.t0 + basic * static_cast<std::int64_t>(row); };
  switch (event.what) {
    case What::joined: {
      const std::uint64_t from = event.number - event.count;
      if (!std::exchange(executor.has_joined, true)) executor.first_row = from;
      if (event.count > event.number || from < executor.next_row)
        violated(event, "expected row " + number(executor.next_row));
      if (event.release != due(event.number)) violated(event, "the row is not on the grid");
      if (event.release < event.at) violated(event, "the row is in the past");
      if (event.count != 0 && event.release - basic >= event.at)
        violated(event, "a row in the future counts as missed");
      // If a crash cut a row short, the rows skipped before that row count as missed.
      if (executor.in_row) {
        count_missed(device, plan, event.device, executor.next_row, from, true);
      }
      count_missed(device, plan, event.device, from, event.number, false);
      executor.in_row = false;
      executor.next_row = event.number;
      break;
    }
    case What::woke:
      if (executor.in_row) violated(event, "it is still in a row");
      if (event.number != executor.next_row) violated(event, "expected row " + number(executor.next_row));
      if (event.release != due(event.number)) violated(event, "the row is not on the grid");
      if (event.at < event.release) violated(event, "it woke too early");
      executor.in_row = true;
      executor.woke_for = event.number;
      executor.woke_at = event.at;
      executor.served.clear();
      for (const std::uint32_t index : plan.periodic) {
        OfModule& module = device.modules[index];
        module.was_in = module.in_tables;
        module.changes_then = module.changes;
      }
      break;
    case What::walked:
      if (!executor.in_row) violated(event, "it did not wake for this row");
      if (event.number != executor.woke_for + event.count) violated(event, "rows are lost");
      if (event.release != due(event.number)) violated(event, "the row is not on the grid");
      if (executor.woke_at < event.release || executor.woke_at - event.release >= basic)
        violated(event, "it woke in the slot of another row");
      count_missed(device, plan, event.device, executor.woke_for, event.number, true);
      check_row(event, device, plan);
      executor.in_row = false;
      executor.next_row = event.number + 1;
      ++executor.cycles;
      break;
    default:
      break;
  }
}

void Invariants::count_missed(OfDevice& device, const schedule::ExecutorPlan& plan, std::uint32_t on,
                              std::uint64_t from, std::uint64_t to, bool as_woken) {
  for (const std::uint32_t index : plan.periodic) {
    OfModule& module = device.modules[index];
    const bool in = as_woken ? module.was_in : module.in_tables;
    (in ? module.missed : module.out) += rows_of(plan, index, period_of(on, index)).in(from, to);
  }
}

// Checks the releases of missed rows that modules catch up on. The executor serves these releases before the
// releases of the present row: the missed rows in their order, and in each row the modules in the order of
// the table. A module gets only its newest missed releases, as many as its limit allows. These releases were
// counted as missed before, so they are subtracted here.
std::vector<Invariants::Served>::const_iterator Invariants::check_made_up(
    const Event& event, OfDevice& device, const schedule::ExecutorPlan& plan) {
  const std::vector<Served>& served = device.executors[event.executor].served;
  const auto name = [&](std::uint32_t module) { return model_of(event.device).modules[module].name; };
  auto next = served.begin();
  std::uint64_t last_row = 0;
  std::size_t last_place = 0;
  for (; next != served.end() && next->number && next->release < event.release; ++next) {
    const model::Module& model = model_of(event.device).modules[next->module];
    const model::OverrunContract contract = model::contract_of(model_of(event.device), model);
    const Rows rows = rows_of(plan, next->module, period_of(event.device, next->module));
    const std::uint64_t row = rows.first + *next->number * rows.stride;
    if (contract.what != model::Overrun::catch_up) violated(event, name(next->module) + " must not catch up");
    if (next->release != device.t0 + plan.basic_period * static_cast<std::int64_t>(row))
      violated(event, name(next->module) + " got a wrong release");
    if (rows.in(row, event.number) > static_cast<std::uint64_t>(contract.limit))
      violated(event, name(next->module) + " caught up beyond its limit");
    const std::vector<std::uint32_t> of_row = plan.row(row % plan.rows());
    const auto place =
        static_cast<std::size_t>(std::find(of_row.begin(), of_row.end(), next->module) - of_row.begin());
    if (row < last_row || (row == last_row && place < last_place))
      violated(event, name(next->module) + " caught up in the wrong order");
    last_row = row;
    last_place = place;
    --device.modules[next->module].missed;
  }
  return next;
}

// True for a process module that catches up. Such a module may get several releases at once, and not all of
// them appear in the events.
bool Invariants::has_pending_releases(std::uint32_t device, std::uint32_t module) const {
  const model::Module& model = model_of(device).modules[module];
  return model.type == model::ModuleType::process &&
         model::contract_of(model_of(device), model).what == model::Overrun::catch_up;
}

void Invariants::check_row(const Event& event, OfDevice& device, const schedule::ExecutorPlan& plan) {
  const OfExecutor& executor = device.executors[event.executor];
  const std::vector<std::uint32_t> row = plan.row(event.number % plan.rows());
  const auto name = [&](std::uint32_t module) { return model_of(event.device).modules[module].name; };
  auto next = check_made_up(event, device, plan);
  for (const std::uint32_t index : row) {
    OfModule& module = device.modules[index];
    if (has_pending_releases(event.device, index)) continue;
    const bool same = module.changes == module.changes_then;
    if (next == executor.served.end() || next->module != index) {
      if (module.was_in && same) violated(event, name(index) + " was not served at its place in the row");
      ++module.out;
      continue;
    }
    if (!module.was_in && same) violated(event, name(index) + " was served while it was out of the tables");
    const Rows rows = rows_of(plan, index, period_of(event.device, index));
    if (next->number &&
        (*next->number != (event.number - rows.first) / rows.stride || next->release != event.release))
      violated(event, name(index) + " got a wrong release");
    ++next;
  }
  if (next != executor.served.end()) violated(event, name(next->module) + " was served in the wrong place");
}

void Invariants::on_module(const Event& event, OfDevice& device) {
  const model::Module& model = model_of(event.device).modules[event.module];
  OfModule& module = device.modules[event.module];
  const bool scheduled = model.operation != model::Operation::non_real;
  switch (event.what) {
    case What::put_in:
      if (module.in_tables) violated(event, "it was already in the tables");
      if (module.raised) violated(event, "its error was not handled");
      if (module.state != lifecycle::State::start && module.state != lifecycle::State::executing)
        violated(event, std::string{"its state is "} + lifecycle::to_text(module.state));
      module.in_tables = true;
      ++module.changes;
      break;
    case What::taken_out:
      if (!module.in_tables) violated(event, "it was not in the tables");
      module.in_tables = false;
      ++module.changes;
      module.failed = false;
      module.raised |= event.error != ErrorType::none;
      break;
    case What::ready: {
      const bool again = module.ready_until && module.ready_changes == module.changes;
      if (again) violated(event, "its condition was checked again before it had run");
      if (!module.in_tables) violated(event, "it is not in the tables");
      const Nanoseconds least = model.interarrival.value_or(Nanoseconds{0});
      if (module.last_ready && event.release - *module.last_ready < least)
        violated(event, "it was released before its interarrival time had passed");
      if (model.deadline && event.until != event.release + *model.deadline)
        violated(event, "the deadline of this run is wrong");
      module.last_ready = event.release;
      module.ready_until = event.until;
      module.ready_changes = module.changes;
      break;
    }
    case What::run:
      if (!module.in_tables) violated(event, "it is not in the tables");
      if (module.failed) violated(event, "it has failed but is still in the tables");
      if (scheduled) on_run(event, device);
      break;
    case What::ran: {
      ++module.cycles;  // a run during which the host ended is not counted
      if (!scheduled) {
        module.failed = event.error != ErrorType::none;
        break;
      }
      OfExecutor& executor = device.executors[executor_of(event.device, event.module)];
      auto& runs = model.operation == model::Operation::sporadic ? executor.sporadic : executor.runs;
      if (runs != event.module) violated(event, "it was not running");
      runs.reset();
      module.failed = event.error != ErrorType::none;
      break;
    }
    case What::released:
    case What::busy: {
      const bool periodic = model.operation == model::Operation::periodic;
      if (event.what == What::released) ++module.cycles;
      if (event.what == What::busy) module.busy += event.count;
      if (!periodic || has_pending_releases(event.device, event.module)) break;
      OfExecutor& executor = device.executors[executor_of(event.device, event.module)];
      if (!executor.in_row) violated(event, "no row is running");
      executor.served.push_back({event.module,
                                 event.what == What::busy ? std::nullopt : std::optional{event.number},
                                 event.release});
      break;
    }
    case What::body:
      if (model.dispatch == model::Dispatch::immediate) {
        ++module.cycles;
        if (!module.in_tables) violated(event, "it is not in the tables");
      }
      break;
    case What::step:
      on_step(event, module);
      break;
    default:
      break;
  }
}

void Invariants::on_run(const Event& event, OfDevice& device) {
  const std::uint32_t on = executor_of(event.device, event.module);
  OfExecutor& executor = device.executors[on];
  OfModule& module = device.modules[event.module];
  if (model_of(event.device).modules[event.module].operation == model::Operation::periodic) {
    if (!executor.in_row) violated(event, "no row is running");
    if (executor.runs) violated(event, "another module of the row is running");
    executor.runs = event.module;
    executor.served.push_back({event.module, event.number, event.release});
    return;
  }
  if (executor.sporadic) violated(event, "another sporadic module is running");
  executor.sporadic = event.module;
  if (!module.ready_until) violated(event, "it was not ready");
  for (const std::uint32_t other : plan_of(event.device).executors[on].sporadic) {
    const OfModule& o = device.modules[other];
    if (other == event.module || !o.ready_until || o.ready_changes != o.changes || !o.in_tables) continue;
    if (module.ready_until && *o.ready_until < *module.ready_until)
      violated(event, model_of(event.device).modules[other].name + " has an earlier deadline");
  }
  module.ready_until.reset();
}

void Invariants::on_step(const Event& event, OfModule& module) {
  const lifecycle::Transition& step = event.step;
  if (step.sequence != module.steps + 1) violated(event, "step " + number(module.steps + 1) + " is missing");
  if (step.from != module.state)
    violated(event, std::string{"its state was "} + lifecycle::to_text(module.state));
  if (lifecycle::next(step.from, step.event, module.before_error) != step.to)
    violated(event, "the lifecycle's table has no such step");
  if (step.event == lifecycle::Event::error) {
    module.before_error = step.from;
    module.raised = false;
  }
  if (module.in_tables && step.to != lifecycle::State::executing) violated(event, "it is in the tables");
  module.steps = step.sequence;
  module.state = step.to;
}

void Invariants::on_sample(const Event& event) {
  OfConnection& connection = connections_[versions_[event.version].numbers[event.connection]];
  switch (event.what) {
    case What::wrote:
      // The numbers of a device that begins again begin at the next multiple of 2^32.
      if (event.number != connection.wrote + 1 &&
          (event.number < connection.wrote || static_cast<std::uint32_t>(event.number) != 1))
        violated(event, "expected number " + number(connection.wrote + 1));
      connection.wrote = event.number;
      break;
    case What::arrived:
      if (event.number > connection.wrote) violated(event, "it was not written yet");
      if (event.number <= connection.arrived)
        violated(event, "sample " + number(connection.arrived) + " arrived earlier");
      connection.arrived = event.number;
      break;
    case What::read:
      if (event.count != 0) {
        violated(event, "its bytes are not those of one sample");
        break;
      }
      if (event.number > connection.wrote) violated(event, "it was not written yet");
      if (event.number <= connection.read)
        violated(event, "sample " + number(connection.read) + " was read earlier");
      connection.read = event.number;
      break;
    default:
      break;
  }
}

// Returns the first row that the executor ran or missed.
std::uint64_t Invariants::first_row(const OfDevice& device, std::size_t executor, const Totals& totals) {
  const OfExecutor& one = device.executors[executor];
  return one.has_joined ? one.first_row : totals.executors[executor].next_row;
}

void Invariants::close(std::uint32_t index, const Totals& totals) {
  const model::Device& model = model_of(index);
  OfDevice& device = devices_[index];
  // If the last row never ended, the rows skipped before it count as missed.
  for (std::size_t e = 0; e < model.executors.size(); ++e) {
    const OfExecutor& executor = device.executors[e];
    if (!executor.in_row) continue;
    count_missed(device, plan_of(index).executors[e], index, executor.next_row, totals.executors[e].next_row,
                 true);
  }
  const auto wrong = [this](const std::string& who, const std::string& what, std::uint64_t counted,
                            std::uint64_t happened) {
    if (counted == happened || violations_.size() >= kMaxViolations) return;
    violations_.push_back(who + " counted " + number(counted) + " " + what + " but there were " +
                          number(happened));
  };
  for (std::size_t e = 0; e < model.executors.size(); ++e) {
    const std::string who = model.name + " executor " + model.executors[e].name;
    const Totals::OfExecutor& counted = totals.executors[e];
    wrong(who, "rows", counted.cycles, device.executors[e].cycles);
    wrong(who, "executed or missed rows", counted.cycles + counted.missed,
          counted.next_row - first_row(device, e, totals));
  }
  for (std::size_t m = 0; m < model.modules.size(); ++m) {
    const std::string who = model.name + "." + model.modules[m].name;
    const Totals::OfModule& counted = totals.modules[m];
    const OfModule& happened = device.modules[m];
    const bool pending = has_pending_releases(index, static_cast<std::uint32_t>(m));
    if (!pending) wrong(who, "releases", counted.cycles, happened.cycles);
    wrong(who, "steps", counted.steps, happened.steps);
    if (model.modules[m].operation == model::Operation::periodic && !pending) {
      wrong(who, "missed releases", counted.missed, happened.missed);
      const schedule::ExecutorPlan& plan =
          plan_of(index).executors[executor_of(index, static_cast<std::uint32_t>(m))];
      const Rows due = rows_of(plan, static_cast<std::uint32_t>(m), *model.modules[m].period);
      const std::size_t on = executor_of(index, static_cast<std::uint32_t>(m));
      const std::uint64_t rows = totals.executors[on].next_row;
      wrong(who, "releases including missed, busy and omitted ones",
            counted.cycles + counted.missed + happened.busy + happened.out - happened.twice,
            due.in(first_row(device, on, totals), rows));
      if (model.modules[m].type == model::ModuleType::process)
        wrong(who, "overruns", counted.overruns, happened.busy);
    }
    if (counted.state != happened.state)
      violations_.push_back(who + " is in " + lifecycle::to_text(counted.state) + ", but its steps lead to " +
                            lifecycle::to_text(happened.state));
  }
  for (const std::uint32_t connection : totals.unbalanced) {
    violations_.push_back("connection " + model::to_text(cell_of(index).connections[connection].from) +
                          " to " + model::to_text(cell_of(index).connections[connection].to) +
                          ": a written sample was neither taken nor overwritten, but is gone");
  }
}

}  // namespace takt::simulation
