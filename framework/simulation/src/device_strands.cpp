// The strands of a simulated device, which are threads and programs on a real one: rows, sporadic modules,
// non-real-time modules, process modules and the gateway.
#include <algorithm>

#include "member.hpp"
#include "network.hpp"

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
/// The time from ringing for the gateway until it has taken the samples.
constexpr Nanoseconds kGatewayShortest = microseconds{15};
constexpr Nanoseconds kGatewayLongest = microseconds{60};
/// The time from the death of a host until its node knows.
constexpr Nanoseconds kEndSeenShortest = microseconds{300};
constexpr Nanoseconds kEndSeenLongest = microseconds{5000};
/// The pause between runs of a non-real-time module without a period.
constexpr Nanoseconds kBackgroundPause = std::chrono::milliseconds{5};

}  // namespace

void Device::begin_strands() {
  for (auto& pointer : rows_) {
    Row& row = *pointer;
    if (row.plan.basic_period == Nanoseconds{0}) continue;
    row.halted = false;
    const model::Executor& executor = model().executors[row.index];
    // Executors that name the same CPU share it.
    row.rows = &world_.kernel.spawn(place_of(row.index, executor.cpu, row.index, 0),
                                    [this, &row] { walk_rows(row); });
    host_strands_.push_back(row.rows);
    if (row.plan.sporadic.empty()) continue;
    row.sporadic = &world_.kernel.spawn(place_of(row.index, executor.cpu, row.index, 1),
                                        [this, &row] { serve_sporadic(row); });
    host_strands_.push_back(row.sporadic);
  }
}

void Device::walk_rows(Row& row) {
  Kernel& kernel = world_.kernel;
  executor::Executor& executor = *row.executor;
  channel::ExecutorBlock& block = channel_.executor(row.index);
  const std::uint64_t missed_before = block.missed.load();
  executor.join_grid(t0_, now());
  emit({.what = What::joined,
        .executor = row.index,
        .number = executor.next_row(),
        .count = block.missed.load() - missed_before,
        .release = executor.next_release()});
  while (true) {
    const Instant release = executor.next_release();
    if (!halt_asked_ && release > now()) {
      static_cast<void>(kernel.wait(release + wake_up(row.draws)));
    }
    if (!halt_asked_ && row.oversleep > Nanoseconds{0})
      static_cast<void>(kernel.wait(now() + std::exchange(row.oversleep, Nanoseconds{0})));
    if (halt_asked_) break;
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
    ring(bits | wake_word_->take_pending());
  }
  row.rows = nullptr;
  row.halted = row.sporadic == nullptr;
}

void Device::serve_sporadic(Row& row) {
  while (!halt_asked_) {
    const std::uint32_t rings = wake_word_->rings.load();
    while (!halt_asked_ && row.executor->run_sporadic()) {
      emit_table_changes(row.index);
      ring_pending();
    }
    if (halt_asked_ || wake_word_->rings.load() != rings) continue;
    row.sporadic_on_wake_word = true;
    static_cast<void>(world_.kernel.wait());
    row.sporadic_on_wake_word = false;
  }
  row.sporadic = nullptr;
  row.halted = row.rows == nullptr;
}

// Corresponds to host::Host::run_background().
void Device::run_background(Member& member) {
  channel::ModuleBlock& block = member.block;
  const Nanoseconds period = member.model.period.value_or(Nanoseconds{0});
  Cycle cycle{.number = 0, .time = now(), .period = period};
  while (!halt_asked_) {
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
    if (!halt_asked_) static_cast<void>(world_.kernel.wait(cycle.time));
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
      leave(member, "the process exited with status 1");  // a program reports a failure in this way
    slot.run.record((now() - started).count());
    emit({.what = What::done, .took = now() - started}, member);
    const std::int64_t late = to_ns(now()) - release - slot.deadline_ns;
    if (slot.deadline_ns != 0 && late > 0) {
      slot.late_by_ns.store(late);
      slot.late.fetch_add(1);
    }
    ring_pending();
  }
  leave(member, "the process exited with status 0");
}

// Ends the program; its node sees this a little later.
void Device::leave(Member& member, const char* how) {
  member.program = nullptr;
  member.spins = member.on_wake_word = false;
  world_.kernel.at(now() + draws_.between(kEndSeenShortest, kEndSeenLongest),
                   [this, &member, how] { program_ended(member, how); });
  world_.kernel.end();
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
      taken.count = slot.released.load();  // it was taken out of the tables in between
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

// Emits events for what the executor has done since the last call and modules do not report themselves.
void Device::emit_table_changes(std::uint32_t executor) {
  const Row& row = *rows_[executor];
  const auto released = [this](Member& member) {
    if (!member.slot || member.slot->immediate != 0) return;
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
  wake_word_->rings.fetch_add(1);
  Kernel& kernel = world_.kernel;
  for (auto& row : rows_) {
    if (row->sporadic_on_wake_word && (bits & channel::kSporadicBit) != 0)
      kernel.wake(*row->sporadic, futex_wake_up(row->draws));
  }
  for (auto& member : members_) {
    if (member->on_wake_word && (bits & member->slot->wake_bit) != 0)
      kernel.wake(*member->program, futex_wake_up(member->draws));
  }
  if ((bits & channel::kGatewayBit) == 0 || gateway_awake_) return;
  gateway_awake_ = true;
  wake_word_->gateway_sleeps.store(0);
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
  wake_word_->gateway_sleeps.store(1);
  gateway_awake_ = false;
}

void Device::arrive(Wire& wire, const std::byte* sample, std::int64_t wall_ns) {
  if (phase_ == Phase::ended) return;
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
  wake_word_->note(wire.link().block().wake_bits);
  ring_pending();
}

// Called by a strand of the host, which ends together with the host.
void Device::crash_host(Member& member) {
  end_host(member.index, ErrorType::crash, "the host was ended by signal 11 in run()");
  world_.kernel.end();
}

void Device::end_host(std::optional<std::uint32_t> culprit, ErrorType type, const std::string& why) {
  if (!host_runs_) return;
  host_runs_ = false;
  host_end_seen_ = false;
  ++host_;  // its pending requests get no answer
  for (Strand* strand : host_strands_) {
    if (strand != world_.kernel.running()) world_.kernel.kill(*strand);
  }
  host_strands_.clear();
  for (auto& row : rows_) {
    row->rows = row->sporadic = nullptr;
    row->sporadic_on_wake_word = false;
    row->halted = true;
  }
  emit({.what = What::host_ended, .text = why});
  world_.kernel.at(now() + draws_.between(kEndSeenShortest, kEndSeenLongest),
                   [this, culprit, type, why] { host_is_seen_ended(culprit, type, why); });
}

void Device::inject(const Fault& fault) {
  const std::string text = to_text(fault, world_.cell);
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
  }
  emit({.what = What::fault, .text = text});
}

}  // namespace takt::simulation
