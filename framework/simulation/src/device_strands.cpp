// The strands of a simulated device, which are threads and programs on a real one: rows, sporadic modules,
// non-real-time modules, process modules and the gateway.
#include <algorithm>
#include <map>
#include <string>

#include "member.hpp"
#include "network.hpp"
#include "virtual_platform.hpp"

namespace takt::simulation {

namespace {

using std::chrono::microseconds;

/// The delay of a wake-up by the clock, including the final spin.
Nanoseconds wake_up(Draws& draws) {
  if (draws.chance(0.001)) return draws.between(Nanoseconds{microseconds{1}}, Nanoseconds{microseconds{30}});
  return draws.between(Nanoseconds{100}, Nanoseconds{1000});
}
/// The delay of a futex wake-up from another CPU.
Nanoseconds futex_wake_up(Draws& draws) {
  return draws.between(Nanoseconds{microseconds{4}}, Nanoseconds{microseconds{30}});
}
/// The time until a store to a slot is visible to another CPU.
Nanoseconds store_seen(Draws& draws) { return draws.between(Nanoseconds{100}, Nanoseconds{500}); }
/// The time from waking the gateway until it has taken the samples.
constexpr Nanoseconds kGatewayShortest = microseconds{15};
constexpr Nanoseconds kGatewayLongest = microseconds{60};
/// The pause between runs of a non-real-time module without a period.
constexpr Nanoseconds kBackgroundPause = std::chrono::milliseconds{5};

}  // namespace

void Device::walk_rows(Row& row) {
  Kernel& kernel = world_.kernel;
  executor::Executor& executor = *row.executor;
  channel::ExecutorBlock& block = parts_->channel.executor(row.index);
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

// Corresponds to host::Host::run_background().
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
      }
    }
    ring_pending();
    block.background.end();
    cycle.time = std::max(cycle.time + (period == Nanoseconds{0} ? kBackgroundPause : period), now());
    if (!member.host->halting()) static_cast<void>(world_.kernel.wait(cycle.time));
  }
}

// Corresponds to libtakt_process in the user's program.
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
          {.text = "ended with status 1", .code = 1});  // a program reports a failure in this way
    slot.run.record((now() - started).count());
    emit({.what = What::done, .took = now() - started}, member);
    const std::int64_t late = to_ns(now()) - release - slot.deadline_ns;
    if (slot.deadline_ns != 0 && late > 0) {
      slot.late_by_ns.store(late);
      slot.late.fetch_add(1);
    }
    ring_pending();
  }
  member.process->leave({.text = "ended with status 0"});
}

// Returns false if the program has to end.
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
      taken.count = slot.released.load();  // the program was taken out of the tables in between
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

// Emits events for the executor's actions since the last call, except those that modules report themselves.
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

// The gateway takes all samples for other devices, and sleeps again.
void Device::forward_samples() {
  std::int64_t next = channel::kNever;
  for (const auto& wire : wires_) {
    if (wire->reader()) continue;
    channel::LinkReader reader{wire->link()};
    while (reader.take(to_ns(now()))) {
      const std::byte* sample = wire->link().payload(reader.buffer());
      if (!is_whole(sample, wire->connection()))
        emit({.what = What::read, .connection = wire->connection(), .number = number_of(sample), .count = 1});
      world_.network->send(wire->connection(), sample, wall_of(reader.info().stamp_ns));
    }
    next = std::min(next, reader.news_at());
  }
  if (next != channel::kNever) {  // a sample is there but not valid yet
    world_.kernel.at(from_ns(next), [this] { forward_samples(); });
    return;
  }
  wake_word().gateway_sleeps.store(1);
  gateway_awake_ = false;
}

void Device::arrive(Wire& wire, const std::byte* sample, std::int64_t wall_ns) {
  if (phase() == Phase::ended) return;
  const std::int64_t stamp = wall_ns - wall_offset_.count();
  if (wire.model().lifespan && to_ns(now()) - stamp > wire.model().lifespan->count()) {
    emit({.what = What::lost,
          .connection = wire.connection(),
          .number = number_of(sample),
          .text = "too old"});
    return;
  }
  channel::LinkWriter writer{wire.link()};
  std::copy_n(sample, kSampleBytes, wire.link().payload(writer.buffer()));
  writer.publish(kSampleBytes, stamp);
  emit({.what = What::arrived, .connection = wire.connection(), .number = number_of(sample)});
  wake_word().note(wire.link().block().wake_bits);
  ring_pending();
}

void Device::command(std::uint32_t module, const Fault& fault) {
  using supervision::Verb;
  static const std::map<Fault::Kind, Verb> verbs{{Fault::Kind::initialize, Verb::initialize},
                                                 {Fault::Kind::start, Verb::start},
                                                 {Fault::Kind::stop, Verb::stop},
                                                 {Fault::Kind::recover, Verb::recover},
                                                 {Fault::Kind::reset, Verb::reset},
                                                 {Fault::Kind::destruct, Verb::destruct}};
  const auto verb = verbs.find(fault.kind);
  const std::string name = verb == verbs.end() ? "swap" : supervision::name_of(verb->second);
  const auto done = [this, module, name](const supervision::Outcome& outcome) {
    const std::string text = name + ": " + (outcome.code == REPLY_OK ? "done" : outcome.text);
    emit({.what = What::answered, .text = text}, *members_[module]);
  };
  if (verb == verbs.end())
    supervisor_->swap(module, "", done);
  else
    supervisor_->command(module, verb->second, done);
}

void Device::inject(const Fault& fault) {
  emit({.what = What::fault, .text = to_text(fault, world_.cell)});
  if (fault.hook != channel::Doing::run) return members_[fault.place]->in_hooks.push_back(fault);
  switch (fault.kind) {
    case Fault::Kind::late:
      members_[fault.place]->late_by += fault.by;
      break;
    case Fault::Kind::crash:
      members_[fault.place]->to_crash = true;
      break;
    case Fault::Kind::fail:
      members_[fault.place]->to_fail = true;
      break;
    case Fault::Kind::hang:
      members_[fault.place]->to_hang = true;
      break;
    case Fault::Kind::unmended:
      members_[fault.place]->unmended += fault.count;
      break;
    case Fault::Kind::oversleep:
      rows_[fault.place]->oversleep += fault.by;
      break;
    case Fault::Kind::clock_step:
      wall_offset_ += fault.by;
      break;
    case Fault::Kind::cut:
      world_.network->cut(fault.device, fault.place, fault.by);
      break;
    case Fault::Kind::lose:
      world_.network->lose(fault.place, fault.count);
      break;
    case Fault::Kind::delay:
      world_.network->delay(fault.place, fault.by);
      break;
    case Fault::Kind::initialize:
    case Fault::Kind::start:
    case Fault::Kind::stop:
    case Fault::Kind::recover:
    case Fault::Kind::reset:
    case Fault::Kind::destruct:
    case Fault::Kind::swap:
      command(fault.place, fault);
      break;
  }
}

}  // namespace takt::simulation
