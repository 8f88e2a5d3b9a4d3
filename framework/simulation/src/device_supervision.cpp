// The supervision of a simulated device: what takt-node does on a real one, on virtual time. Each step goes
// through the lifecycle's table, and lifecycle::Recovery decides when to try again.
#include <algorithm>

#include "member.hpp"

namespace takt::simulation {

namespace {

using channel::Doing;

using lifecycle::State;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// The interval at which a node checks its modules.
constexpr Nanoseconds kLookEvery = milliseconds{5};
/// The duration of a hook.
constexpr Nanoseconds kHookShortest = microseconds{50};
constexpr Nanoseconds kHookLongest = milliseconds{3};
/// The time of a program from its start to its first wait.
constexpr Nanoseconds kAttachShortest = milliseconds{2};
constexpr Nanoseconds kAttachLongest = milliseconds{20};
/// The time until a host accepts requests.
constexpr Nanoseconds kHostShortest = milliseconds{5};
constexpr Nanoseconds kHostLongest = milliseconds{30};
/// Time limits for the executors to end their rows, and for a program to reach its wait.
constexpr Nanoseconds kHaltLimit = seconds{2};
constexpr Nanoseconds kProgramEndLimit = seconds{1};

/// A run() or a body that takes longer counts as hanging.
Nanoseconds stuck_after(const model::Module& module) {
  const Nanoseconds own = module.period ? *module.period : module.deadline.value_or(Nanoseconds{0});
  return seconds{1} + std::min<Nanoseconds>(10 * own, seconds{60});
}

}  // namespace

bool Device::apply(Member& member, lifecycle::Event event, const std::string& text, ErrorType error) {
  const auto step = member.machine.apply(event);
  if (!step) return false;
  emit({.what = What::step, .error = error, .step = *step, .text = text}, member);
  return true;
}

void Device::stop_for(Problem problem) {
  if (phase_ == Phase::running) fail_device(std::move(problem));
}

void Device::fail_device(Problem problem) {
  failures_.push_back(std::move(problem));
  stop();
}

void Device::step() {
  if (phase_ == Phase::ended) return;
  for (auto& member : members_) {
    if (member->is_process() && member->scheduled()) watch_program(*member);
  }
  watch_rows();
  if (phase_ == Phase::preparing) prepare_step();
  if (phase_ == Phase::running) {
    for (auto& member : members_) supervise(*member);
  }
  if (phase_ == Phase::stopping) stopping_step();
  if (phase_ == Phase::ended) return;
  world_.kernel.at(now() + kLookEvery, [this] { step(); });
}

// First every module is initialised, then every module is started.
void Device::prepare_step() {
  const auto all = [this](auto&& holds) {
    return std::all_of(members_.begin(), members_.end(), [&](const auto& member) { return holds(*member); });
  };
  if (all([](const Member& m) { return m.state() == State::start; })) {
    phase_ = Phase::ready;
    return;
  }
  if (!all([](const Member& m) { return m.state() != State::idle; })) return;
  for (auto& member : members_) {
    if (member->state() != State::initialize || member->pending) continue;
    if (member->is_thread())
      ask(*member, Doing::start);
    else if (!member->scheduled() || member->slot->phase.load() == channel::ReleaseSlotPhase::ready)
      apply(*member, lifecycle::Event::start);
  }
}

void Device::go(Instant t0) {
  phase_ = Phase::running;
  t0_ = t0;
  channel_.host(0).t0_ns.store(to_ns(t0));
  for (auto& member : members_) {
    if (member->slot) member->slot->t0_ns.store(to_ns(t0));
  }
  for (auto& member : members_) {
    if (member->scheduled()) put_in_tables(*member);
  }
  rows_begun_ = true;
  begin_strands();
}

// A counter that grows when a row names the module: the module's cycles, or the executor's cycles for a
// sporadic module, whose condition each row checks.
std::uint64_t Device::cycles_of(const Member& member) const {
  return (member.sporadic() ? channel_.executor(member.executor).cycles : member.block.cycles).load();
}

channel::Place Device::removal_of(const Member& member) const {
  return {.index = member.index,
          .block = &member.block,
          .executor = member.scheduled() ? &channel_.executor(member.executor) : nullptr,
          .slot = member.slot.get()};
}

void Device::put_in_tables(Member& member) {
  member.seen_cycles = cycles_of(member);
  member.put_in_at = now();
  channel::put_in(removal_of(member));
  member.reported_in_tables = true;
  emit(What::put_in, member);
  if (member.slot && member.slot->immediate != 0) ring(member.slot->wake_bit);
}

void Device::take_from_tables(Member& member) {
  member.removal.begin(removal_of(member));
  if (!std::exchange(member.reported_in_tables, false)) return;
  emit(What::taken_out, member);
}

bool Device::is_out(const Member& member) const { return member.removal.over(removal_of(member)); }

void Device::supervise(Member& member) {
  if (!member.scheduled() && member.state() == State::start) {
    const bool walked = std::all_of(members_.begin(), members_.end(), [this](const auto& m) {
      return !m->scheduled() || channel_.executor(m->executor).cycles.load() > 0;
    });
    if (!walked || (member.is_thread() && !host_runs_)) return;
    if (member.is_thread()) {
      put_in_tables(member);
      Strand& strand =
          world_.kernel.spawn({.cpu = nullptr, .priority = 0}, [this, &member] { run_background(member); });
      host_strands_.push_back(&strand);
    }
    apply(member, lifecycle::Event::run);
    return;
  }
  if (member.lost) return;
  watch_inputs(member);
  if (const auto type = member.block.error.load(); type != 0) {
    const std::string text{member.block.error_text.view()};
    member.block.error.store(0);
    if (member.state() == State::start) apply(member, lifecycle::Event::run);  // its first run failed
    raise(member, static_cast<ErrorType>(type), text);
    if (static_cast<ErrorType>(type) == ErrorType::overrun &&
        (member.contract.what == model::Overrun::stop_device ||
         member.contract.what == model::Overrun::stop_cell)) {
      if (member.contract.what == model::Overrun::stop_cell) world_.stop_cell(index_, text);
      fail_device(
          {"module " + model().name + "." + member.model.name, "overrun: " + text,
           std::string{"give it more time, or another <overrun> than "} + to_text(member.contract.what)});
      return;
    }
  }
  if (member.state() == State::start && member.in_tables() && cycles_of(member) != member.seen_cycles)
    apply(member, lifecycle::Event::run);
  if (member.state() == State::recover && !member.pending) attempt_recovery(member);
}

// Checks the inputs of programs. Thread modules check theirs before each run.
void Device::watch_inputs(Member& member) {
  if (!member.slot || member.state() != State::executing || !member.in_tables()) return;
  for (Member::Input& input : member.inputs) {
    channel::LinkBlock& block = input.wire->link().block();
    if (block.deadline_ns <= 0) continue;
    const std::int64_t newest = std::max(block.newest_ns.load(), to_ns(member.put_in_at));
    const bool late = to_ns(now()) - newest > block.deadline_ns;
    if (late && !input.late) block.late.fetch_add(1);
    input.late = late;
    if (!late || input.wire->model().stale != model::Stale::error) continue;
    ++member.errors;
    raise(member, ErrorType::stale,
          "the newest value of input '" + input.wire->model().to.port + "' is too old");
    return;
  }
}

void Device::watch_program(Member& member) {
  if (!member.alive || phase_ == Phase::stopping) return;
  channel::ReleaseSlot& slot = *member.slot;
  const channel::ReleaseSlotPhase phase = slot.phase.load();
  switch (member.state()) {
    case State::idle:
      if (phase != channel::ReleaseSlotPhase::empty) apply(member, lifecycle::Event::initialize);
      return;
    case State::recover:
      if (member.started_again) {
        if (phase == channel::ReleaseSlotPhase::ready) recovered(member);
        return;
      }
      break;
    case State::start:
    case State::executing:
      break;
    case State::initialize:
    case State::destruct:
      return;
  }
  if (slot.in_body() && member.program != nullptr &&
      now() - from_ns(slot.release_ns.load()) >= stuck_after(member.model)) {
    member.killed_for_hanging = true;
    end_program(member, true, "the process did not return to its wait and was ended");
    return;
  }
  const std::uint64_t late = slot.late.load();
  if (std::exchange(member.seen_late, late) == late) return;
  if (member.model.miss != model::Miss::error || !member.in_tables()) return;
  if (member.state() == State::start) apply(member, lifecycle::Event::run);  // its first body was late
  ++member.errors;
  raise(member, ErrorType::deadline, "its body ended after its deadline");
}

// Ends the host if a run() hangs.
void Device::watch_rows() {
  if (!host_runs_) return;
  const auto look = [this](const channel::Activity& activity) {
    const std::uint32_t busy = activity.module.load();
    if (busy == 0 || now() - from_ns(activity.since_ns.load()) < stuck_after(members_[busy - 1]->model))
      return false;
    end_host(busy - 1, ErrorType::hang, "run() did not return, so the host was ended");
    return true;
  };
  for (std::size_t e = 0; e < channel_.executors(); ++e) {
    if (look(channel_.executor(e).row) || look(channel_.executor(e).sporadic)) return;
  }
}

// Calls hooks one after the other; before T0 they take no time.
void Device::ask(Member& member, Doing hook) {
  member.pending = hook;
  const Nanoseconds takes =
      phase_ == Phase::preparing ? Nanoseconds{0} : member.draws.between(kHookShortest, kHookLongest);
  hooks_free_at_ = std::max(hooks_free_at_, now()) + takes;
  world_.kernel.at(hooks_free_at_, [this, &member, hook, host = host_] {
    if (host != host_ || !host_runs_ || member.lost || member.pending != hook) return;
    member.pending.reset();
    answered(member, hook);
  });
}

void Device::answered(Member& member, Doing hook) {
  switch (hook) {
    case Doing::load:
      connect(member);
      if (member.state() == State::destruct) apply(member, lifecycle::Event::reset);
      ask(member, Doing::initialize);
      break;
    case Doing::initialize:
      apply(member, lifecycle::Event::initialize);
      if (phase_ == Phase::running) ask(member, Doing::start);
      break;
    case Doing::start:
      apply(member, lifecycle::Event::start);
      if (rows_begun_ && member.scheduled()) put_in_tables(member);
      break;
    case Doing::recover:
      if (member.unmended != 0) {
        --member.unmended;
        not_recovered(member, "recover() failed");
      } else {
        recovered(member);
      }
      break;
    case Doing::destruct:
      if (member.machine.accepts(lifecycle::Event::destruct)) apply(member, lifecycle::Event::destruct);
      break;
    case Doing::error:
    case Doing::nothing:
    case Doing::run:
    case Doing::condition:
    case Doing::serve:
      break;
  }
}

// Raises an error of a module; the executor may have taken it out of its table already.
void Device::raise(Member& member, ErrorType type, const std::string& text, std::optional<Instant> since) {
  take_from_tables(member);
  member.why = std::string{takt::to_text(type)} + ": " + text;
  if (!apply(member, lifecycle::Event::error, text, type)) return;
  member.stale = type == ErrorType::stale;
  member.recovery.failed(now(), since);
  if (member.is_thread()) ask(member, Doing::error);
}

void Device::attempt_recovery(Member& member) {
  if (member.alive && (member.started_again || !is_out(member))) return;
  if (member.is_thread() && !host_runs_) return;
  // Waiting for another module to send does not count as an attempt.
  if (member.stale && member.model.recovery.attempts > 0) {
    for (const Member::Input& input : member.inputs) {
      const channel::LinkBlock& block = input.wire->link().block();
      if (block.deadline_ns <= 0 || input.wire->model().stale != model::Stale::error) continue;
      const std::int64_t newest = block.newest_ns.load();
      if (newest == 0 || to_ns(now()) - newest > block.deadline_ns) return;
    }
  }
  switch (member.recovery.next(now())) {
    case lifecycle::Recovery::Step::wait:
      return;
    case lifecycle::Recovery::Step::give_up:
      give_up(member);
      return;
    case lifecycle::Recovery::Step::attempt:
      break;
  }
  emit({.what = What::recovery,
        .number = static_cast<std::uint64_t>(member.recovery.attempts()),
        .count = static_cast<std::uint64_t>(member.model.recovery.attempts)},
       member);
  if (member.is_thread()) {
    ask(member, Doing::recover);
  } else if (member.unmended != 0) {
    --member.unmended;
    not_recovered(member, "the process could not be started again");
  } else if (member.alive || !member.scheduled()) {
    recovered(member);
  } else {
    member.started_again = true;
    spawn(member);
  }
}

void Device::recovered(Member& member) {
  member.recovery.attempted(now(), true);
  member.started_again = false;
  if (apply(member, lifecycle::Event::recover) && rows_begun_ && (member.scheduled() || member.is_thread()))
    put_in_tables(member);
}

void Device::not_recovered(Member& member, const std::string& text) {
  member.why = text;
  member.recovery.attempted(now(), false);
}

void Device::give_up(Member& member) {
  member.failed = true;
  apply(member, lifecycle::Event::give_up,
        "after " + std::to_string(member.recovery.attempts()) + " attempts");
  if (member.is_thread() && !member.lost) ask(member, Doing::destruct);
  Problem problem{"module " + model().name + "." + member.model.name, "was given up: " + member.why, ""};
  if (member.model.recovery.then == model::GiveUp::stop_cell) world_.stop_cell(index_, to_text(problem));
  if (member.model.recovery.then != model::GiveUp::destruct)
    fail_device(std::move(problem));
  else
    failures_.push_back(std::move(problem));
}

// Loses a module: none of its hooks is called any more.
void Device::lose(Member& member, const std::string& text, ErrorType type) {
  take_from_tables(member);
  member.lost = true;
  member.failed = true;
  member.pending.reset();
  member.why = text;
  if (member.machine.accepts(lifecycle::Event::error)) apply(member, lifecycle::Event::error, text, type);
  if (member.machine.accepts(lifecycle::Event::give_up))
    apply(member, lifecycle::Event::give_up, text, type);
  else if (member.machine.accepts(lifecycle::Event::destruct))
    apply(member, lifecycle::Event::destruct, text, type);
  Problem problem{"module " + model().name + "." + member.model.name, text, ""};
  if (member.model.recovery.then == model::GiveUp::stop_cell && phase_ == Phase::running)
    world_.stop_cell(index_, to_text(problem));
  if (member.model.recovery.then != model::GiveUp::destruct && phase_ == Phase::running)
    fail_device(std::move(problem));
  else
    failures_.push_back(std::move(problem));
}

void Device::host_is_seen_ended(std::optional<std::uint32_t> culprit, ErrorType type,
                                const std::string& why) {
  host_end_seen_ = true;
  for (std::size_t e = 0; e < channel_.executors(); ++e) {
    channel::ExecutorBlock& executor = channel_.executor(e);
    executor.row.end();
    executor.sporadic.end();
    executor.row_sequence.store(executor.row_sequence.load() & ~std::uint64_t{1});
  }
  for (auto& member : members_) {
    member->block.background.end();
    if (member->is_thread()) take_from_tables(*member);
    member->pending.reset();
  }
  if (culprit) {
    ++members_[*culprit]->errors;
    lose(*members_[*culprit], why, type);
  }
  if (phase_ == Phase::stopping) {
    halted_ = true;
    for (auto& member : members_) member->lost |= member->is_thread();
    return;
  }
  if (phase_ != Phase::running) return;
  start_host();
}

void Device::start_host() {
  host_runs_ = true;
  const bool first = host_ == 0;
  const Nanoseconds takes = first ? Nanoseconds{0} : draws_.between(kHostShortest, kHostLongest);
  hooks_free_at_ = now() + takes;
  // Values between two modules of the former host ended with it.
  for (auto& wire : wires_) {
    const auto is_thread = [this](Wire::End end) { return end && members_[*end]->is_thread(); };
    if (is_thread(wire->writer()) && is_thread(wire->reader()) && !first) wire->drop();
  }
  make_executors();
  emit({.what = What::host_began});
  // A module whose instance died with the host through no fault of its own is reloaded.
  for (auto& member : members_) {
    if (!member->is_thread() || member->lost) continue;
    if (!first) {
      if (member->state() == State::destruct) continue;
      member->block.error.store(0);
      apply(*member, lifecycle::Event::destruct, "its host ended");
    }
    ask(*member, Doing::load);
  }
  if (first) return;  // rows begin at T0
  world_.kernel.at(now() + takes, [this, host = host_] {
    if (host == host_ && phase_ == Phase::running) begin_strands();
  });
}

void Device::spawn(Member& member) {
  channel::clear_for_new_program(*member.slot);
  member.reported_releases = 0;
  member.alive = true;
  member.killed_for_hanging = false;
  member.end_requested_at = {};
  const Nanoseconds takes =
      phase_ == Phase::preparing ? Nanoseconds{0} : member.draws.between(kAttachShortest, kAttachLongest);
  member.program = &world_.kernel.spawn(place_of(member), [this, &member, from = now() + takes] {
    world_.kernel.sleep_until(from);
    run_program(member);
  });
}

void Device::end_program(Member& member, bool killed, const std::string& why) {
  if (member.program == nullptr) return;
  if (!killed) {
    member.slot->end.store(1);
    ring(~0U);
    return;
  }
  world_.kernel.kill(*member.program);
  member.program = nullptr;
  member.spins = member.on_wake_word = false;
  program_ended(member, why);
}

void Device::program_ended(Member& member, const std::string& text) {
  ring(~0U);  // wakes the readers of its last samples
  member.alive = false;
  if (member.state() == State::destruct) return;
  if (phase_ == Phase::stopping) {
    take_from_tables(member);  // the last row may still come
    if (member.machine.accepts(lifecycle::Event::stop)) apply(member, lifecycle::Event::stop);
    apply(member, lifecycle::Event::destruct, text);
    return;
  }
  if (member.state() == State::start && member.in_tables() && cycles_of(member) != member.seen_cycles)
    apply(member, lifecycle::Event::run);
  if (member.state() == State::recover) {
    member.started_again = false;
    not_recovered(member, text);
    return;
  }
  take_from_tables(member);
  ++member.errors;
  if (member.killed_for_hanging)
    raise(member, ErrorType::hang, text, from_ns(member.slot->release_ns.load()));
  else
    raise(member, ErrorType::crash, text);
}

void Device::stop() {
  if (phase_ == Phase::stopping || phase_ == Phase::ended) return;
  phase_ = Phase::stopping;
  asked_at_ = now();
  halt_asked_ = true;
  // Wakes the strands so that they see the halt. A strand in a row ends it first.
  for (Strand* strand : host_strands_) world_.kernel.wake(*strand);
  halted_ = !host_runs_ && host_end_seen_;
}

void Device::stopping_step() {
  if (!halted_) {
    const bool all =
        std::all_of(host_strands_.begin(), host_strands_.end(), [](const Strand* s) { return s->ended(); });
    if (host_runs_ && all) {
      halted_ = true;
    } else if (host_runs_ && now() - asked_at_ > kHaltLimit) {
      end_host(std::nullopt, ErrorType::hang, "the executors did not halt, so the host was ended");
      return;
    } else {
      return;
    }
    host_strands_.clear();
  }
  if (rows_begun_) {
    rows_begun_ = false;
    emit({.what = What::halted});
  }
  bool all = true;
  for (auto& pointer : members_) {
    Member& member = *pointer;
    take_from_tables(member);
    all &= member.state() == State::destruct && !member.alive;
    if (member.alive) {
      if (member.end_requested_at == Instant{}) {
        member.end_requested_at = now();
        end_program(member, false, "");
      } else if (now() - member.end_requested_at > kProgramEndLimit) {
        end_program(member, true, "the process was ended by signal 15");
      }
    } else if (member.state() != State::destruct && !member.pending) {
      if (member.machine.accepts(lifecycle::Event::stop)) apply(member, lifecycle::Event::stop);
      if (member.is_process() || member.lost || !host_runs_ || member.state() == State::idle)
        apply(member, lifecycle::Event::destruct);
      else
        ask(member, Doing::destruct);
    }
  }
  if (all) phase_ = Phase::ended;
}

}  // namespace takt::simulation
