// The strands of a simulated device: rows, sporadic modules, non-real-time modules, process modules and the
// gateway. On a real device, these are threads and processes.
#include <algorithm>
#include <map>
#include <string>

#include "member.hpp"
#include "network.hpp"
#include "node.hpp"
#include "virtual_platform.hpp"

namespace takt::simulation {

namespace {

using std::chrono::microseconds;

/// The delay of a wake-up by the clock, including the spinning at its end.
Nanoseconds wake_up(Draws& draws) {
  if (draws.chance(0.001)) return draws.between(Nanoseconds{microseconds{1}}, Nanoseconds{microseconds{30}});
  return draws.between(Nanoseconds{100}, Nanoseconds{1000});
}
/// The delay of a futex wake-up from another CPU.
Nanoseconds futex_wake_up(Draws& draws) {
  return draws.between(Nanoseconds{microseconds{4}}, Nanoseconds{microseconds{30}});
}
/// The time until another CPU sees a store to a slot.
Nanoseconds store_seen(Draws& draws) { return draws.between(Nanoseconds{100}, Nanoseconds{500}); }
/// The time from the wake-up of the gateway until the gateway has taken the samples.
constexpr Nanoseconds kGatewayShortest = microseconds{15};
constexpr Nanoseconds kGatewayLongest = microseconds{60};
/// The pause between runs of a non-real-time module without a period.
constexpr Nanoseconds kBackgroundPause = std::chrono::milliseconds{5};

}  // namespace

void Device::walk_rows(Row& row) {
  Kernel& kernel = world_.kernel;
  executor::Executor& executor = *row.executor;
  channel::ExecutorBlock& block = parts_->channel.executor(row.index);
  block.row.thread.store(kernel.running()->id());
  const std::uint64_t missed_before = block.missed.load();
  executor.join_grid(row.host.t0(), now());
  emit({.what = What::joined,
        .executor = row.index,
        .number = executor.next_row(),
        .count = block.missed.load() - missed_before,
        .release = executor.next_release()});
  while (true) {
    const Instant release = executor.next_release();
    if (!row.host.halting() && release > now()) {
      static_cast<void>(kernel.wait(release + wake_up(row.draws)));
    }
    if (!row.host.halting() && row.oversleep > Nanoseconds{0})
      static_cast<void>(kernel.wait(now() + std::exchange(row.oversleep, Nanoseconds{0})));
    if (row.host.halting()) break;
    emit_table_changes(row.index);
    emit({.what = What::woke, .executor = row.index, .number = executor.next_row(), .release = release});
    const std::uint64_t missed = block.missed.load();
    const std::uint32_t bits = executor.run_cycle(now());
    emit_table_changes(row.index);
    emit({.what = What::walked,
          .executor = row.index,
          .number = executor.next_row() - 1,
          .count = block.missed.load() - missed,
          .release = executor.next_release() - executor.basic_period()});
    ring(bits | wake_word().take_pending());
  }
}

void Device::serve_sporadic(Row& row) {
  parts_->channel.executor(row.index).sporadic.thread.store(world_.kernel.running()->id());
  while (!row.host.halting()) {
    const std::uint32_t rings = wake_word().rings.load();
    while (!row.host.halting() && row.executor->run_sporadic()) {
      emit_table_changes(row.index);
      ring_pending();
    }
    if (row.host.halting() || wake_word().rings.load() != rings) continue;
    row.sporadic_on_wake_word = true;
    static_cast<void>(world_.kernel.wait());
    row.sporadic_on_wake_word = false;
  }
  row.sporadic = nullptr;
}

// Runs a non-real-time thread module in the same way as host::Host::run_background().
void Device::run_background(Member& member) {
  channel::ModuleBlock& block = member.block;
  const Nanoseconds period = member.model.period.value_or(Nanoseconds{0});
  Cycle cycle{.number = 0, .time = now(), .period = period};
  while (!member.host->halting()) {
    const Instant start = now();
    block.background.announce(member.index, channel::Doing::run, to_ns(start));
    if (block.in_tables.load() != 0) {
      if (period == Nanoseconds{0}) cycle.time = start;
      cycle.start = start;
      const executor::Outcome outcome = member.body.run(cycle);
      block.jitter.record((cycle.time - start).count());
      block.run.record((now() - start).count());
      block.cycles.fetch_add(1);
      ++cycle.number;
      if (!outcome.ok()) {
        block.in_tables.store(0);
        block.errors.fetch_add(1);
        block.error_text.assign(outcome.text);
        block.error.store(static_cast<std::uint32_t>(outcome.type));
        member.reported_in_tables = false;
        emit({.what = What::taken_out, .error = outcome.type}, member);
      } else if (outcome.finished) {
        block.in_tables.store(0);
        block.finished.store(1);
        member.reported_in_tables = false;
        emit({.what = What::taken_out}, member);
      }
    }
    ring_pending();
    block.background.end();
    cycle.time = std::max(cycle.time + (period == Nanoseconds{0} ? kBackgroundPause : period), now());
    if (!member.host->halting()) static_cast<void>(world_.kernel.wait(cycle.time));
  }
}

// Runs a process module in the same way as libtakt_process.
void Device::run_program(Member& member) {
  channel::ReleaseSlot& slot = *member.slot;
  connect(member);
  slot.phase.store(channel::ReleaseSlotPhase::attached);
  channel::Taken taken;
  while (true) {
    slot.done.store(taken.count);
    if (taken.count == 0) slot.phase.store(channel::ReleaseSlotPhase::ready);
    if (!await_release(member, taken)) break;
    taken = channel::take(slot, taken.count);
    const Instant started = now();
    const std::int64_t release = taken.release_ns;
    slot.jitter.record(release - to_ns(started));
    emit({.what = What::body, .number = taken.cycle, .release = from_ns(release)}, member);
    const executor::Outcome outcome = work(member, from_ns(release), started);
    if (!outcome.ok())
      member.process->leave(
          {.text = "ended with status 1", .code = 1});  // a process module reports a failure in this way
    slot.run.record((now() - started).count());
    emit({.what = What::done, .took = now() - started}, member);
    const std::int64_t late = to_ns(now()) - release - slot.deadline_ns;
    if (slot.deadline_ns != 0 && late > 0) {
      slot.late_by_ns.store(late);
      slot.late.fetch_add(1);
    }
    ring_pending();
    if (outcome.finished) break;
  }
  member.process->leave({.text = "ended with status 0"});
}

// Waits for the next release of a process module. Returns false if the module must end.
bool Device::await_release(Member& member, channel::Taken& taken) {
  channel::ReleaseSlot& slot = *member.slot;
  Kernel& kernel = world_.kernel;
  const auto released = [&] { return slot.released.load() != taken.count; };
  const bool immediate = slot.immediate != 0;
  if (!immediate && taken.count != 0 && !released() && slot.end.load() == 0) {
    const Instant expected = from_ns(taken.release_ns + slot.period_ns);
    const Nanoseconds margin{slot.margin_cap_ns};
    kernel.sleep_until(expected - margin / 2);
    if (!released() && now() < expected + margin) {
      member.spins = true;
      static_cast<void>(kernel.wait(expected + margin));
      member.spins = false;
    }
  }
  while (!released()) {
    if (slot.end.load() != 0) return false;
    const std::int64_t event = immediate ? news_at(member) : channel::kNever;
    const Instant from = from_ns(std::max(event, channel::not_before_ns(slot)));
    if (event != channel::kNever && now() >= from) {
      if (channel::begin(slot, to_ns(now()))) return true;
      taken.count = slot.released.load();  // begin() failed, because the module has left the tables
      slot.done.store(taken.count);
    }
    slot.sleeping.store(1);
    Instant until = Instant::max();
    if (event != channel::kNever && slot.open.load() != 0) until = from;
    member.on_wake_word = true;
    if (!released() && until > now()) static_cast<void>(kernel.wait(until));
    member.on_wake_word = false;
    slot.sleeping.store(0);
  }
  return true;
}

// Emits an event for each of the executor's actions since the last call: releases, overruns, and removals of
// modules from the tables.
void Device::emit_table_changes(std::uint32_t executor) {
  const Row& row = *rows_[executor];
  const auto released = [this](Member& member) {
    if (member.slot == nullptr || member.slot->immediate != 0) return;
    const std::uint32_t releases = member.slot->released.load();
    if (releases != member.reported_releases) {
      member.reported_releases = releases;
      emit({.what = What::released,
            .number = member.slot->cycle(releases),
            .release = from_ns(member.slot->release_ns.load())},
           member);
      if (member.spins) world_.kernel.wake(*member.program, store_seen(member.draws));
    }
    const std::uint64_t overruns = member.block.overruns.load();
    if (overruns != member.reported_overruns)
      emit({.what = What::busy, .count = overruns - member.reported_overruns}, member);
    member.reported_overruns = overruns;
  };
  for (const auto& member : members_) {
    if (!member->scheduled() || member->executor != executor) continue;
    if (member->reported_in_tables && !member->in_tables()) {
      member->reported_in_tables = false;
      emit({.what = What::taken_out,
            .error = static_cast<ErrorType>(member->block.error.load()),
            .text = member->block.error_text.view()},
           *member);
    }
  }
  for (const std::uint32_t index : row.in_priority) released(*members_[index]);
}

void Device::ring(std::uint32_t bits) {
  if (bits == 0) return;
  wake_word().rings.fetch_add(1);
  Kernel& kernel = world_.kernel;
  for (Row* row : rows_) {
    if (row != nullptr && row->sporadic_on_wake_word && (bits & channel::kSporadicBit) != 0)
      kernel.wake(*row->sporadic, futex_wake_up(row->draws));
  }
  for (auto& member : members_) {
    if (member->on_wake_word && (bits & member->slot->wake_bit) != 0)
      kernel.wake(*member->program, futex_wake_up(member->draws));
  }
  if ((bits & channel::kGatewayBit) == 0 || gateway_awake_) return;
  gateway_awake_ = true;
  wake_word().gateway_sleeps.store(0);
  kernel.at(now() + draws_.between(kGatewayShortest, kGatewayLongest), [this] { forward_samples(); });
}

// Does the work of the gateway: takes all samples for other devices, sends them, and sleeps until the next
// wake-up.
void Device::forward_samples() {
  if (has_lost_power_) return;
  std::int64_t next = channel::kNever;
  for (const auto& link : links_) {
    if (link->reader()) continue;
    channel::LinkReader reader{link->link()};
    while (reader.take(to_ns(now()))) {
      const std::byte* sample = link->link().payload(reader.buffer());
      if (!is_whole(sample, link->number()))
        emit({.what = What::read, .connection = link->connection(), .number = number_of(sample), .count = 1});
      world_.network->send(version_, *link, sample, node_.wall_of(from_ns(reader.info().stamp_ns)));
    }
    next = std::min(next, reader.news_at());
  }
  if (next != channel::kNever) {  // a sample has been written but is not valid yet
    world_.kernel.at(from_ns(next), [this] { forward_samples(); });
    return;
  }
  wake_word().gateway_sleeps.store(1);
  gateway_awake_ = false;
}

void Device::arrive(SimulatedLink& link, const std::byte* sample, std::int64_t wall_ns) {
  if (phase() == Phase::ended) return;
  const std::int64_t stamp = to_ns(now()) - std::max<std::int64_t>(node_.wall_of(now()) - wall_ns, 0);
  if (link.model().lifespan && to_ns(now()) - stamp > link.model().lifespan->count()) {
    emit({.what = What::lost,
          .connection = link.connection(),
          .number = number_of(sample),
          .text = "too old"});
    return;
  }
  channel::LinkWriter writer{link.link()};
  std::copy_n(sample, kSampleBytes, link.link().payload(writer.buffer()));
  writer.publish(kSampleBytes, stamp);
  emit({.what = What::arrived, .connection = link.connection(), .number = number_of(sample)});
  wake_word().note(link.link().block().wake_bits);
  ring_pending();
}

void Device::command(std::uint32_t module, const Injection& injection) {
  using supervision::Verb;
  static const std::map<Injection::Kind, Verb> verbs{{Injection::Kind::initialize, Verb::initialize},
                                                     {Injection::Kind::start, Verb::start},
                                                     {Injection::Kind::stop, Verb::stop},
                                                     {Injection::Kind::recover, Verb::recover},
                                                     {Injection::Kind::reset, Verb::reset},
                                                     {Injection::Kind::destruct, Verb::destruct}};
  const auto verb = verbs.find(injection.kind);
  const std::string name = verb == verbs.end() ? "swap" : supervision::name_of(verb->second);
  const auto done = [this, module, name](const supervision::Outcome& outcome) {
    const std::string text = name + ": " + (outcome.code == REPLY_OK ? "done" : outcome.text);
    emit({.what = What::answered, .text = text}, *members_[module]);
  };
  if (verb == verbs.end())
    supervisor_->swap(module, "", {}, done);
  else
    supervisor_->command(module, verb->second, done);
}

void Device::inject(const Injection& injection) {
  if (injection.hook != channel::Doing::run) return members_[injection.target]->in_hooks.push_back(injection);
  switch (injection.kind) {
    case Injection::Kind::late:
      members_[injection.target]->late_by += injection.by;
      break;
    case Injection::Kind::crash:
      members_[injection.target]->to_crash = true;
      break;
    case Injection::Kind::fail:
      members_[injection.target]->to_fail = true;
      break;
    case Injection::Kind::hang:
      members_[injection.target]->to_hang = true;
      break;
    case Injection::Kind::finish:
      members_[injection.target]->to_finish = true;
      break;
    case Injection::Kind::unmended:
      members_[injection.target]->unmended += injection.count;
      break;
    case Injection::Kind::oversleep:
      rows_[injection.target]->oversleep += injection.by;
      break;
    case Injection::Kind::initialize:
    case Injection::Kind::start:
    case Injection::Kind::stop:
    case Injection::Kind::recover:
    case Injection::Kind::reset:
    case Injection::Kind::destruct:
    case Injection::Kind::swap:
      command(injection.target, injection);
      break;
    default:  // not a fault of a module or an executor
      break;
  }
}

}  // namespace takt::simulation
