#include <takt/supervision/supervisor.hpp>

#include <algorithm>

#include <takt/core/words.hpp>
#include <takt/schedule/plan.hpp>
#include "fault_notes.hpp"
#include "forces.hpp"
#include "health.hpp"
#include "hosted.hpp"
#include "limits.hpp"
#include "member.hpp"
#include "properties.hpp"
#include "watch.hpp"

namespace takt::supervision {

using channel::Doing;
using lifecycle::Event;
using lifecycle::State;

Supervisor::Supervisor(Options options, std::shared_ptr<Platform> platform)
    : options_(std::move(options)),
      parts_{.cell = std::move(options_.cell),
             .device = options_.device,
             .paths = std::move(options_.paths),
             .ports = std::move(options_.ports)},
      platform_(std::move(platform)),
      notes_(std::make_unique<FaultNotes>(options_.noted)),
      forces_(std::make_unique<Forces>(
          parts_, members_, *notes_,
          [this](const Member& member, const std::string& text) { log(member, text); })),
      health_(std::make_unique<Health>(parts_, members_, flows_, *notes_, options_.is_lost)),
      properties_(std::make_unique<Properties>()) {}

Supervisor::~Supervisor() = default;

void Supervisor::log(const Member& member, const std::string& text) const {
  platform_->log(member.model.name, text);
}

void Supervisor::log(const std::string& text) const { platform_->log("", text); }

bool Supervisor::apply(Member& member, Event event, const std::string& text, ErrorType error) {
  const auto step = member.machine.apply(event);
  if (!step) {
    log(member, in_words(step.problems()));
    return false;
  }
  if (event == Event::error) ++member.errors;
  if (member.is_process() && !member.scheduled()) trust(member, step->to == State::executing);
  log(member, std::string{lifecycle::to_text(step->from)} + " -> " + lifecycle::to_text(step->to) +
                  (text.empty() ? "" : " (" + on_one_line(text) + ")"));
  const Step taken{.module = member.index, .transition = *step, .error = error, .text = text};
  platform_->stepped(taken);
  if (event == Event::error && phase_ == Phase::running)
    platform_->fault("module " + member.model.name + ": " + text);
  if (options_.stepped) options_.stepped(taken);
  return true;
}

void Supervisor::fail_device(Problem problem) {
  notes_->note(model::FaultKind::device_failed, in_words({problem}));
  log(to_text(problem));
  failures_.push_back(std::move(problem));
  stop();
}

Result<void> Supervisor::prepare() {
  if (auto created = parts_.create(); !created) return created;
  if (auto begun = platform_->begin(parts_); !begun) return begun;
  watches_.resize(parts_.plan.executors.size());
  auto flows = platform_->open_flows();
  if (!flows) return flows.problems();
  flows_ = std::move(*flows);

  for (std::size_t i = 0; i < parts_.shares.size(); ++i) {
    hosts_.push_back(
        std::make_unique<Hosted>(parts_.shares[i], i, parts_.channel.host(i), platform_->make_host(i)));
  }
  for (std::uint32_t i = 0; i < device().modules.size(); ++i) {
    members_.push_back(std::make_unique<Member>(device().modules[i], i, parts_.channel.module(i)));
    Member& member = *members_.back();
    member.inputs = parts_.wiring.with_deadline(i);
    if (member.is_process()) {
      member.program = platform_->make_program(i);
      member.slot = parts_.slot_of(i);
      if (member.slot != nullptr) fill_slot(member);
    }
    begin_log(member, time());
  }
  for (const auto& host : hosts_) {
    for (const auto* of : {&host->share.modules, &host->share.programs}) {
      for (const std::uint32_t index : *of) members_[index]->host = host->index;
    }
  }
  for (const auto& host : hosts_) {
    if (auto started = host->process->start(); !started) return started;
  }
  asked_at_ = time();
  for (auto& member : members_) {
    if (member->is_thread()) {
      ask(*member, Doing::load);
    } else if (!member->scheduled()) {
      apply(*member, Event::initialize);  // a non-real-time program has no hooks to call
    } else if (auto spawned = spawn(*member); !spawned) {
      lose(*member, in_words(spawned.problems()));
    }
  }
  return {};
}

// Writes the platform's detections to the log and to the fault record.
void Supervisor::report_detections() {
  for (const Detection& detection : platform_->detections()) {
    if (!detection.module) {
      log(detection.text);
      continue;
    }
    const Member& member = *members_.at(*detection.module);
    log(member, detection.text);
    if (!detection.cause.empty()) notes_->note(member, model::FaultKind::not_real_time, detection.cause);
  }
}

// Returns how long something has lasted. If the machine has stood still in the meantime, only the time since
// then counts, so that nothing exceeds its limit because of a pause.
Nanoseconds Supervisor::lasted(Instant since) const {
  return std::max(stepped_at_ - std::max(since, moving_since_), Nanoseconds{0});
}

void Supervisor::step() {
  const Instant now = time();
  passed_ = stepped_at_ == Instant{} ? Nanoseconds{0} : now - stepped_at_;
  stepped_at_ = now;
  if (passed_ > kStoodStill) moving_since_ = now;
  platform_->step(now);
  // Take the log lines before the end of a process is handled, so that the last lines precede the report of a
  // crash.
  for (auto& member : members_) take_lines(*member, now);
  for (const auto& host : hosts_) {
    take_answers(*host);
    if (auto end = host->process->ended()) {
      take_answers(*host);
      host_ended(*host, *end);
    }
  }
  for (auto& member : members_) {
    if (member->is_process()) check_process(*member);
  }
  step_properties(now);
  forces_->check(now);
  if (phase_ == Phase::ended) return;
  if (flows_) flows_->step(now);
  check_writers();
  pass_on_clocks();
  for (const auto& host : hosts_) check_host(*host, now);
  report_detections();
  health_->check_counts();
  if (rows_begun_) health_->check_ports(now);
  if (phase_ == Phase::preparing) prepare_step();
  if (phase_ == Phase::preparing || phase_ == Phase::ready || phase_ == Phase::running) running_step(now);
  if (phase_ == Phase::stopping) stopping_step(now);
  for (auto& member : members_) {
    if (member->command) step_command(*member, now);
  }
}

Result<Tapped> Supervisor::tap(std::uint32_t module, const std::string& port, Instant until,
                               Nanoseconds every) {
  if (!flows_) return fail("this device is not connected to DDS");
  const std::string name = device().name + "." + device().modules[module].name;
  const auto& ports = parts_.ports[module];
  if (!ports)
    return fail("the ports of module " + name + " are not known", "connect one of them in the descriptor");
  for (const model::Port& each : *ports) {
    if (each.role == model::Role::plain || model::name_of_service(each) != port ||
        each.direction == model::Direction::out) {
      continue;
    }
    if (each.role != model::Role::client) return open_service(module, each, until);
    return fail(in_quotes(port) + " of module " + name + " is a client and cannot be called",
                "call the service that it is connected to");
  }
  std::vector<std::string> names;
  for (const model::Port& each : *ports) names.push_back(model::name_of_service(each));
  const std::vector<std::string_view> known{names.begin(), std::unique(names.begin(), names.end())};
  const auto found =
      std::find_if(ports->begin(), ports->end(), [&](const model::Port& p) { return p.name == port; });
  if (found == ports->end()) {
    return fail("module " + name + " has no port " + in_quotes(port),
                known.empty() ? "it has no ports" : suggestion(port, known));
  }
  if (found->direction != model::Direction::out) {
    const std::string by = forces_->by(*members_.at(module), port);
    const std::string input =
        "port " + name + "." + port + " is an input" + (by.empty() ? "" : ", which is forced by " + by);
    for (const model::Connection& connection : parts_.cell.connections) {
      if (connection.to.device != device().name || connection.to.module != device().modules[module].name ||
          connection.to.port != port) {
        continue;
      }
      return fail(input, connection.from.given()
                             ? "use the output that it is connected to: " + connection.from.device + "." +
                                   connection.from.module + "." + connection.from.port
                             : "its samples are on topic " + connection.topic);
    }
    return fail("port " + name + "." + port + " is an input without a connection");
  }
  if (auto tapped = flows_->tap(module, port, until, every); !tapped) return tapped.problems();
  const PlannedFlow& flow = *parts_.wiring.flow_of(module, port);
  return Tapped{flow.topic, model::to_text(flow.type), flow.reliable};
}

Result<std::string> Supervisor::force(std::uint32_t module, const ForceRequest& request) {
  if (phase_ != Phase::running) return fail("the device is not running");
  return forces_->force(*members_.at(module), request, time());
}

Result<void> Supervisor::end_force(std::uint32_t module, const std::string& port, const std::string& who) {
  return forces_->end(*members_.at(module), port, who);
}

Result<Tapped> Supervisor::open_service(std::uint32_t module, const model::Port& request, Instant until) {
  const std::string name = device().name + "." + device().modules[module].name;
  const std::string service = model::name_of_service(request);
  const Member& member = *members_[module];
  if (member.state() != State::executing)
    return fail(
        "module " + name + " is in " + lifecycle::to_text(member.state()) + ", but answers only in EXECUTING",
        "run takt start " + name);
  if (auto opened = flows_->open_service(module, service, until); !opened) return opened.problems();
  const auto& ports = *parts_.ports[module];
  const auto reply = std::find_if(ports.begin(), ports.end(), [&](const model::Port& port) {
    return port.name == service + model::kReplyPort;
  });
  if (reply == ports.end())
    return fail("service " + in_quotes(service) + " of " + name + " has no reply port");
  return Tapped{port_topic(parts_.cell.name, {device().name, device().modules[module].name, request.name}),
                model::to_text(request.type), true,
                port_topic(parts_.cell.name, {device().name, device().modules[module].name, reply->name}),
                model::to_text(reply->type)};
}

const lifecycle::Machine& Supervisor::machine(std::uint32_t module) const {
  return members_.at(module)->machine;
}

void Supervisor::trace(Nanoseconds last, std::size_t most,
                       std::function<void(const Result<std::string>&)> done) {
  platform_->trace(last, most, std::move(done));
}

// Starts the modules once all of them are initialised. The device is ready when all modules are started and
// the device's flows are open.
void Supervisor::prepare_step() {
  const auto opened = flows_ ? flows_->opened() : Result<void>{};
  if (opened && !opened->ok()) return fail_device(opened->problems()[0]);
  const auto all = [this](auto&& holds) {
    return std::all_of(members_.begin(), members_.end(), [&](const auto& member) { return holds(*member); });
  };
  if (all([](const Member& m) { return m.state() == State::start; })) {
    if (opened) phase_ = Phase::ready;
    return;
  }
  if (!all([](const Member& m) { return m.state() != State::idle; })) return;
  for (auto& member : members_) {
    if (member->state() != State::initialize || member->pending) continue;
    if (member->is_thread()) {
      ask(*member, Doing::start);
    } else if (!member->scheduled()) {
      apply(*member, Event::start);
    } else if (member->slot->phase.load(std::memory_order_acquire) == channel::ReleaseSlotPhase::ready) {
      process_ready(*member);
      apply(*member, Event::start);
    }
  }
}

std::string Supervisor::unmatched() const {
  return parts_.wiring.unmatched([this](std::size_t link) { return flows_->health(link); });
}

void Supervisor::go(Instant t0) {
  if (phase_ != Phase::ready) return;
  phase_ = Phase::running;
  t0_ = t0;
  if (t0 < time()) join_grid(t0);
  // Hosts and process modules read t0 after the request to begin or their first release, which come later.
  for (const auto& host : hosts_) host->block.t0_ns.store(to_ns(t0), std::memory_order_release);
  for (auto& member : members_) {
    if (member->slot != nullptr) member->slot->t0_ns.store(to_ns(t0), std::memory_order_relaxed);
  }
  begin_rows();
}

// Sets the first row of each executor, so that a restored deployment continues on its grid. The rows between
// T0 and now do not count as missed.
void Supervisor::join_grid(Instant t0) {
  const Instant first = time() + kJoinGridAhead;
  for (std::size_t e = 0; e < parts_.plan.executors.size(); ++e) {
    const Nanoseconds basic = parts_.plan.executors[e].basic_period;
    if (basic == Nanoseconds{0}) continue;
    const auto rows = static_cast<std::uint64_t>((first - t0 + basic - Nanoseconds{1}) / basic);
    parts_.channel.executor(e).next_row.store(rows, std::memory_order_relaxed);
  }
}

// Returns a counter that grows with each row that contains the module. For a periodic module, the counter
// counts the calls or releases. For a sporadic module, whose condition is checked in every row of its
// executor, the counter counts these rows.
std::uint64_t Supervisor::cycles_of(const Member& member) const {
  const bool sporadic = member.model.operation == model::Operation::sporadic;
  const auto& cycles = sporadic ? parts_.channel.executor(executor_of(member)).cycles : member.block.cycles;
  return cycles.load(std::memory_order_relaxed);
}

channel::ModuleMemory Supervisor::memory_of(const Member& member) const {
  return {.index = member.index,
          .block = &member.block,
          .executor = member.scheduled() ? &parts_.channel.executor(executor_of(member)) : nullptr,
          .slot = member.slot};
}

void Supervisor::put_in_tables(Member& member) {
  member.seen_cycles = cycles_of(member);
  member.put_in_at = time();
  member.put_in = true;
  trust(member, true);
  channel::put_in(memory_of(member));
  platform_->in_tables(member.index, true);
  // Events that arrived while the module was out of the tables are already in the module's queues and do not
  // wake the module. So wake it here.
  if (member.slot != nullptr && member.slot->immediate != 0) platform_->wake(member.slot->wake_bit);
}

void Supervisor::take_from_tables(Member& member) {
  forces_->end_all(member, "the module left its table");
  trust(member, false);
  member.put_in = false;
  member.removal.begin(memory_of(member));
  platform_->in_tables(member.index, false);
}

bool Supervisor::is_out(const Member& member) const {
  if (member.is_process() && !member.scheduled()) return !member.runs();
  return member.removal.over(memory_of(member));
}

std::size_t Supervisor::executor_of(const Member& member) const { return parts_.executor_of(member.model); }

void Supervisor::running_step(Instant now) {
  // Background modules begin when each executor that has rows has executed its first row.
  if (rows_begun_ && !background_begun_ && now >= *t0_) {
    bool walked = true;
    for (const auto& member : members_) {
      if (member->scheduled()) {
        walked &= parts_.channel.executor(executor_of(*member)).cycles.load(std::memory_order_relaxed) > 0;
      }
    }
    if (walked) {
      background_begun_ = true;
      for (const auto& host : hosts_) host->process->ask({.what = host::Request::Do::background});
      for (auto& member : members_) {
        if (member->scheduled() || !member->wanted() || member->state() != State::start) continue;
        if (member->is_thread()) {
          if (!member->put_in) put_in_tables(*member);  // a command may have put the module in already
        } else if (auto spawned = spawn(*member); !spawned) {
          raise(*member, ErrorType::crash, in_words(spawned.problems()));
        } else {
          apply(*member, Event::run);
        }
      }
    }
  }

  for (auto& pointer : members_) {
    Member& member = *pointer;
    if (member.lost) continue;
    check_inputs(member, now);
    // Handle an error that the executor detected.
    if (const auto type = member.block.error.load(std::memory_order_acquire); type != 0) {
      std::string text = on_one_line(member.block.error_text.view());
      if (static_cast<ErrorType>(type) == ErrorType::budget) text += " of " + to_text(*member.model.budget);
      member.block.error.store(0, std::memory_order_relaxed);
      if (member.state() == State::start) apply(member, Event::run);  // the module's first run failed
      raise(member, static_cast<ErrorType>(type), text);
      const model::Overrun contract = model::contract_of(device(), member.model).what;
      if (static_cast<ErrorType>(type) == ErrorType::overrun &&
          (contract == model::Overrun::stop_device || contract == model::Overrun::stop_cell)) {
        stops_cell_ |= contract == model::Overrun::stop_cell;
        fail_device(
            {"module " + device().name + "." + member.model.name, "overrun: " + text,
             std::string{"give it more time, or choose an <overrun> other than "} + to_text(contract)});
        return;
      }
    }
    if (member.has_finished()) {
      finish(member, now);
      continue;
    }
    if (member.state() == State::start && member.in_tables() && rows_begun_) {
      const bool named = cycles_of(member) != member.seen_cycles ||
                         member.block.background.module.load(std::memory_order_relaxed) != 0;
      if (named) apply(member, Event::run);
    }
    check_cycles(member, now);
    if (member.state() == State::recover && !member.pending) attempt_recovery(member);
  }
}

// Detects a module in the tables that is not called or released any more, although its executor runs rows.
// Its program may have damaged its release slot, for example. The check omits sporadic thread modules, which
// the rows call only if their condition holds, and programs with immediate dispatch, which release
// themselves. The time in which the executor runs no rows does not count, because check_rows() finds out why.
void Supervisor::check_cycles(Member& member, Instant now) {
  const bool in_rows = member.model.operation == model::Operation::periodic ||
                       (member.slot != nullptr && member.slot->immediate == 0);
  if (!in_rows || !member.in_tables() || phase_ != Phase::running || now < *t0_ || !host_of(member).begun ||
      host_of(member).hung || !member.hung.empty()) {
    member.cycles = {};
    return;
  }
  const Nanoseconds limit =
      stands_after(rows_every(member) + member.model.interarrival.value_or(Nanoseconds{0}));
  const bool in_body = member.slot != nullptr && member.slot->in_body();  // check_body() checks the body
  const std::uint64_t cycles = member.block.cycles.load(std::memory_order_relaxed);
  const std::optional<Nanoseconds> ran =
      member.program ? ran_if_starved(member.cycles, limit, member.program->pid()) : std::nullopt;
  const std::size_t executor = executor_of(member);
  const Nanoseconds rows_stand_after = stands_after(parts_.plan.executors[executor].basic_period);
  const bool rows_stand = watches_[executor].cycles.seen_for() >= rows_stand_after / 4;
  const Nanoseconds stood =
      member.cycles.look(in_body ? ~cycles : cycles, rows_stand ? Nanoseconds{0} : passed_, limit, ran);
  if (in_body || stood < limit || has_long_run(now)) return;
  if (member.is_thread())
    return raise(member, ErrorType::hang, "the executor has not called it for " + to_text(limit));
  member.hung = "took no release for " + to_text(limit);
  member.program->kill();
}

// Returns the time between two rows that contain the module.
Nanoseconds Supervisor::rows_every(const Member& member) const {
  return member.model.operation == model::Operation::periodic
             ? *member.model.period
             : parts_.plan.executors[executor_of(member)].basic_period;
}

// Takes a module with an error out of the tables, if the executor has not done so, and moves it to RECOVER.
void Supervisor::raise(Member& member, ErrorType type, const std::string& text, std::optional<Instant> since,
                       const std::string& more, const std::string& attachment) {
  take_from_tables(member);
  member.why = std::string{takt::to_text(type)} + ": " + text;
  notes_->note(member, model::FaultKind::error, text + more, type, attachment);
  if (!apply(member, Event::error, member.why, type)) return;
  member.stale = type == ErrorType::stale;
  member.recovery.failed(time(), since);
  if (member.is_thread()) ask(member, Doing::error, type);
}

void Supervisor::finish(Member& member, Instant now) {
  if (member.state() == State::destruct || member.swap) return;
  if (member.put_in) {
    if (member.state() == State::start)
      apply(member, Event::run);  // the module's first run was also its
                                  // last one
    take_from_tables(member);
  }
  member.up_to = State::idle;
  if (is_out(member)) destruct(member, now);
}

void Supervisor::attempt_recovery(Member& member) {
  const bool alive = member.is_process() && member.runs();
  // A recovery attempt must wait if the program was restarted and has neither become ready nor ended, or if
  // it was not restarted and is still in its body.
  if (alive && (member.started_again || !is_out(member))) return;
  if (phase_ == Phase::stopping || (member.is_thread() && !host_of(member).process->running())) return;
  // After a stale input, the module first waits for a new value. Its first recovery then does not count as an
  // attempt, so that a module is not given up because of pauses of its writer.
  const bool counts = !member.stale;
  if (!counts && member.model.recovery.attempts > 0 && has_stale_input(member, time())) return;
  switch (member.recovery.next(time(), counts)) {
    case lifecycle::Recovery::Step::wait:
      return;
    case lifecycle::Recovery::Step::give_up:
      give_up(member);
      return;
    case lifecycle::Recovery::Step::attempt:
      break;
  }
  log(member, counts ? "recovery, attempt " + std::to_string(member.recovery.attempts()) + " of " +
                           std::to_string(member.model.recovery.attempts)
                     : "recovery, because the value of its input is fresh again");
  platform_->recovering(member.index, counts ? member.recovery.attempts() : 0);
  // After a failed attempt, restart the module without its saved state, because this state may be the cause
  // of the crash.
  if ((member.reload || (member.is_process() && !alive)) && member.recovery.attempts() > 1)
    parts_.saved_of(member.index).clear();
  if (member.is_thread()) {
    ask(member, member.reload ? Doing::load : Doing::recover);
  } else if (alive) {
    recovered(member);
  } else if (auto spawned = spawn(member); !spawned) {
    not_recovered(member, in_words(spawned.problems()));
  } else if (!member.scheduled()) {
    recovered(member);
  } else {
    member.started_again = true;
  }
  if (member.is_process() && !alive && member.runs())
    notes_->note(member, model::FaultKind::program_restart, "its program was restarted");
}

void Supervisor::recovered(Member& member) {
  member.recovery.attempted(time(), true);
  member.started_again = member.reload = false;
  if (!apply(member, Event::recover)) return;
  notes_->note(member, model::FaultKind::recovered,
               (member.stale ? "" : "attempt " + std::to_string(member.recovery.attempts()) + ", ") +
                   "after " + member.why);
  ++member.recoveries;
  if (!member.wanted() && member.state() == State::executing) apply(member, Event::stop);
  if (rows_begun_ && member.wanted() && (member.scheduled() || member.is_thread())) put_in_tables(member);
}

void Supervisor::not_recovered(Member& member, const std::string& text) {
  member.why = text;
  member.stale = false;  // the next attempt counts
  log(member, "could not recover: " + text);
  notes_->note(member, model::FaultKind::not_recovered, text);
  member.recovery.attempted(time(), false);
}

void Supervisor::give_up(Member& member) {
  member.failed = true;
  const std::string cause = std::exchange(member.why, {});
  const auto attempts = member.recovery.attempts();
  member.why = "after " + std::to_string(attempts) + (attempts == 1 ? " attempt: " : " attempts: ") + cause;
  const bool whole_device =
      phase_ == Phase::preparing || member.model.recovery.then != model::GiveUp::destruct;
  const std::string why = member.why + (whole_device ? "" : way_out(member));
  apply(member, Event::give_up, why);
  notes_->note(member, model::FaultKind::given_up, why);
  if (member.is_thread() && !member.lost && !member.reload) ask(member, Doing::destruct);
  member.lost |= member.reload;
  Problem problem{"module " + device().name + "." + member.model.name, "it was given up: " + cause,
                  "correct the module, or give it more attempts in <recovery>"};
  stops_cell_ |= phase_ == Phase::running && member.model.recovery.then == model::GiveUp::stop_cell;
  if (whole_device && (phase_ == Phase::preparing || phase_ == Phase::ready || phase_ == Phase::running)) {
    fail_device(std::move(problem));
  } else {
    log(to_text(problem));
    failures_.push_back(std::move(problem));
  }
}

// Gives up a module whose hooks cannot be called again, because its host crashed or a hook hangs.
void Supervisor::lose(Member& member, const std::string& text, ErrorType type, const std::string& more,
                      const std::string& attachment) {
  const bool starting = phase_ == Phase::preparing;
  const bool whole_device = starting || member.model.recovery.then != model::GiveUp::destruct;
  const std::string why = text + (whole_device ? "" : way_out(member));
  notes_->note(member, model::FaultKind::error, text + more, type, attachment);
  notes_->note(member, model::FaultKind::given_up, why);
  if (member.swap) {
    host_of(member).process->ask({.what = host::Request::Do::give_up_swap, .module = member.index});
    end_swap(member, REPLY_FAILED, text);
  }
  take_from_tables(member);
  member.lost = true;
  member.failed = true;
  member.pending.reset();
  member.why = text;
  if (member.machine.accepts(Event::error)) apply(member, Event::error, text, type);
  if (member.machine.accepts(Event::give_up)) {
    apply(member, Event::give_up, why, type);  // with the text again, because a client that joins later
                                               // receives only the last step
  } else if (member.machine.accepts(Event::destruct)) {
    apply(member, Event::destruct, why, type);
  }
  Problem problem{"module " + device().name + "." + member.model.name, text, ""};
  stops_cell_ |= phase_ == Phase::running && member.model.recovery.then == model::GiveUp::stop_cell;
  if (whole_device && phase_ != Phase::stopping && phase_ != Phase::ended) {
    fail_device(std::move(problem));
  } else {
    log(to_text(problem));
    failures_.push_back(std::move(problem));
  }
}

}  // namespace takt::supervision
