#include <takt/executor/executor.hpp>

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <utility>

#include <takt/core/check.hpp>

namespace takt::executor {

namespace {

constexpr auto relaxed = std::memory_order_relaxed;

// Increments a counter. Each counter has only one writer, so no atomic read-modify-write is needed.
void add(std::atomic<std::uint64_t>& counter, std::uint64_t n = 1) noexcept {
  counter.store(counter.load(relaxed) + n, relaxed);
}

bool in_tables(const Unit& unit) noexcept {
  return unit.block->in_tables.load(std::memory_order_seq_cst) != 0;  // see channel::Removal
}

bool fatal(const Unit& unit) noexcept {
  switch (unit.overrun.what) {
    case model::Overrun::skip:
    case model::Overrun::catch_up:
      return false;
    case model::Overrun::error:
    case model::Overrun::stop_device:
    case model::Overrun::stop_cell:
      return true;
  }
  return false;
}

// Loads the next module's data into the cache while the current module runs.
void prefetch(const Unit& unit) noexcept {
  unit.block->prefetch();
  if (unit.body != nullptr) __builtin_prefetch(unit.body);
  if (unit.slot != nullptr) {
    __builtin_prefetch(&unit.slot->released, 1);
    __builtin_prefetch(&unit.slot->done);
  }
}

// Returns the number of rows before row `to` in which a module is due. The module is due in row `first`, and
// then in every `stride`-th row.
std::uint64_t releases_before(std::uint64_t to, std::uint64_t first, std::uint64_t stride) noexcept {
  return to <= first ? 0 : (to - first + stride - 1) / stride;
}

}  // namespace

Executor::Executor(const schedule::ExecutorPlan& plan, std::vector<Unit> periodic, std::vector<Unit> sporadic,
                   channel::ExecutorBlock& block, Clock& clock, Flight flight)
    : table_(plan.table),
      periodic_(std::move(periodic)),
      sporadic_(std::make_unique<Sporadic[]>(sporadic.size())),
      sporadic_count_(sporadic.size()),
      bodies_seen_(periodic_.size() + sporadic.size()),
      rows_(flight.rows == nullptr ? nowhere_ : *flight.rows),
      runs_(flight.sporadic == nullptr ? nowhere_ : *flight.sporadic),
      block_(block),
      clock_(clock),
      basic_(plan.basic_period),
      rows_in_table_(table_.rows()) {
  TAKT_CHECK(periodic_.size() == plan.periodic.size() && sporadic.size() == plan.sporadic.size());
  for (std::size_t i = 0; i < periodic_.size(); ++i) {
    const Unit& unit = periodic_[i];
    TAKT_CHECK(unit.block != nullptr && (unit.body == nullptr) != (unit.slot == nullptr));
    strides_.push_back(static_cast<std::uint64_t>(unit.period / basic_));
    first_rows_.push_back(static_cast<std::uint64_t>(plan.offsets[i] / basic_));
    only_skip_ &= unit.overrun.what == model::Overrun::skip;
    if (unit.overrun.what == model::Overrun::catch_up) {
      const std::uint64_t rows = strides_.back() * static_cast<std::uint64_t>(unit.overrun.limit);
      longest_catch_up_ = std::max(longest_catch_up_, rows);
    }
  }
  made_up_.resize(periodic_.size());
  for (std::size_t i = 0; i < sporadic_count_; ++i) {
    TAKT_CHECK(sporadic[i].block != nullptr &&
               (sporadic[i].body == nullptr) != (sporadic[i].slot == nullptr));
    sporadic_[i].unit = sporadic[i];
    // Sets the period that the module sees in run(): its condition is checked once in each basic period.
    sporadic_[i].unit.period = basic_;
    has_immediate_ |= sporadic[i].immediate;
  }
}

void Executor::join_grid(Instant t0, Instant now) noexcept {
  TAKT_CHECK(basic_ > Nanoseconds{0});
  row_ = block_.next_row.load(relaxed);
  table_row_ = rows_in_table_ == 0 ? 0 : row_ % rows_in_table_;
  release_ = t0 + basic_ * static_cast<std::int64_t>(row_);
  if (now > release_) skip(static_cast<std::uint64_t>((now - release_ + basic_ - Nanoseconds{1}) / basic_));
}

void Executor::leave_grid(Instant now) noexcept {
  if (now > release_) skip(static_cast<std::uint64_t>((now - release_) / basic_));
}

void Executor::skip(std::uint64_t rows) noexcept {
  if (rows == 0) return;
  for (std::size_t i = 0; i < periodic_.size(); ++i) {
    if (!in_tables(periodic_[i])) continue;
    add(periodic_[i].block->missed, releases_before(row_ + rows, first_rows_[i], strides_[i]) -
                                        releases_before(row_, first_rows_[i], strides_[i]));
  }
  pass(rows);
}

void Executor::pass(std::uint64_t rows) noexcept {
  add(block_.missed, rows);
  row_ += rows;
  if (rows_in_table_ != 0) table_row_ = row_ % rows_in_table_;
  release_ += basic_ * static_cast<std::int64_t>(rows);
  block_.next_row.store(row_, relaxed);
}

std::uint32_t Executor::overrun(std::uint64_t rows) noexcept {
  if (only_skip_) {
    skip(rows);
    return 0;
  }
  for (std::size_t i = 0; i < periodic_.size(); ++i) {
    const Unit& unit = periodic_[i];
    const std::uint64_t first = releases_before(row_, first_rows_[i], strides_[i]);
    const std::uint64_t end = releases_before(row_ + rows, first_rows_[i], strides_[i]);
    made_up_[i] = end;
    if (first == end || !in_tables(unit)) continue;
    const std::uint64_t missed = end - first;
    add(unit.block->missed, missed);
    switch (unit.overrun.what) {
      case model::Overrun::skip:
        break;
      case model::Overrun::catch_up:
        made_up_[i] = end - std::min(missed, static_cast<std::uint64_t>(unit.overrun.limit));
        break;
      case model::Overrun::error:
      case model::Overrun::stop_device:
      case model::Overrun::stop_cell:
        raise_missed(unit, first, missed);
        break;
    }
  }
  pass(rows);
  return longest_catch_up_ == 0 ? 0 : catch_up(rows);
}

// Serves missed releases as far as the overrun contracts allow. overrun() has counted all missed releases;
// each release that is served here is subtracted from that count. So the count stays correct if the host dies
// in between.
std::uint32_t Executor::catch_up(std::uint64_t rows) noexcept {
  std::uint32_t wake = 0;
  Instant time = clock_.now();
  for (std::uint64_t behind = std::min(rows, longest_catch_up_); behind > 0; --behind) {
    const std::uint64_t row = row_ - behind;
    const Instant release = release_ - basic_ * static_cast<std::int64_t>(behind);
    ticket_.after = 0;
    for (const schedule::Table::Index i : table_.row(row % rows_in_table_)) {
      const std::uint64_t number = number_at(i, row);
      if (number < made_up_[i] || !in_tables(periodic_[i])) continue;
      time = serve(i, number, release, time, &wake);
      auto& missed = periodic_[i].block->missed;
      missed.store(missed.load(relaxed) - 1, relaxed);
    }
  }
  return wake;
}

Instant Executor::serve(std::size_t i, std::uint64_t number, Instant release, Instant now,
                        std::uint32_t* wake) noexcept {
  const Unit& unit = periodic_[i];
  if (unit.slot == nullptr) return call(unit, block_.row, rows_, number, release, unit.period, now);
  record_body(unit, bodies_seen_[i]);
  const channel::Release given = channel::release(*unit.slot, number, to_ns(release), &ticket_);
  rows_.add(channel::FlightKind::released, to_ns(now), unit.index, static_cast<std::int64_t>(given));
  switch (given) {
    case channel::Release::wake:
      *wake |= unit.slot->wake_bit;
      [[fallthrough]];
    case channel::Release::given:
      add(unit.block->cycles);
      break;
    case channel::Release::pending:
      add(unit.block->cycles);
      add(unit.block->overruns);
      break;
    case channel::Release::busy:
      add(unit.block->overruns);
      if (fatal(unit))
        raise(unit, ErrorType::overrun, number, "the program had not finished its body at its next release");
      break;
  }
  return now;
}

std::uint32_t Executor::run_cycle(Instant now) noexcept {
  block_.row_sequence.store(block_.row_sequence.load(relaxed) + 1,
                            std::memory_order_seq_cst);  // see channel::Removal
  if (before_ != nullptr) check_trial();
  const bool swapped = asked_.load(relaxed) != nullptr && begin_exchange();
  if ((now - release_).count() > block_.latest_ns.load(relaxed))
    block_.latest_ns.store((now - release_).count(), relaxed);
  const auto record = [&](Nanoseconds late) {
    rows_.add(channel::FlightKind::row, to_ns(now), 0, late.count());
    if (swapped) rows_.add(channel::FlightKind::swapped, to_ns(now), periodic_[tried_].index);
  };
  std::uint32_t wake = 0;
  Instant time = now;
  if (now - release_ >= basic_) {
    const auto rows = static_cast<std::uint64_t>((now - release_) / basic_);
    const Nanoseconds late = (now - release_) % basic_;
    record(late);
    wake = overrun(rows);
    block_.jitter.record(-late.count());
    if (longest_catch_up_ != 0) time = clock_.now();
  } else {
    record(now - release_);
    block_.jitter.record((release_ - now).count());
  }

  const Instant release = release_;
  if (rows_in_table_ != 0) {
    ticket_.after = 0;
    const std::span<const schedule::Table::Index> row = table_.row(table_row_);
    for (std::size_t place = 0; place < row.size(); ++place) {
      if (place + 1 < row.size()) prefetch(periodic_[row[place + 1]]);
      const schedule::Table::Index i = row[place];
      const Unit& unit = periodic_[i];
      if (!in_tables(unit)) continue;
      const std::uint64_t number = number_at(i, row_);
      time = unit.slot == nullptr ? call(unit, block_.row, rows_, number, release, unit.period, time)
                                  : serve(i, number, release, time, &wake);
    }
  }
  if (sporadic_count_ != 0) wake |= check_conditions(release, time);
  block_.row.end();

  add(block_.cycles);
  ++row_;
  table_row_ = table_row_ + 1 == rows_in_table_ ? 0 : table_row_ + 1;
  release_ += basic_;
  block_.next_row.store(row_, relaxed);
  const Instant end = clock_.now();
  rows_.add(channel::FlightKind::row_end, to_ns(end));
  if (end > release_) add(block_.late);
  block_.row_sequence.store(block_.row_sequence.load(relaxed) + 1, std::memory_order_seq_cst);
  return wake;
}

void Executor::exchange(Exchange& exchange) noexcept {
  exchange.state.store(Exchange::State::waiting, relaxed);
  asked_.store(&exchange, std::memory_order_release);  // read by begin_exchange()
}

bool Executor::withdraw() noexcept { return asked_.exchange(nullptr, std::memory_order_acq_rel) != nullptr; }

bool Executor::begin_exchange() noexcept {
  Exchange* exchange = asked_.load(std::memory_order_acquire);  // pairs with the store in exchange()
  if (exchange == nullptr || before_ != nullptr) return false;
  const auto unit = std::find_if(periodic_.begin(), periodic_.end(),
                                 [exchange](const Unit& each) { return each.index == exchange->index; });
  if (unit == periodic_.end() || unit->body == nullptr || !in_tables(*unit)) return false;
  exchange = asked_.exchange(nullptr, std::memory_order_acq_rel);
  if (exchange == nullptr) return false;  // withdraw() has withdrawn the request in the meantime
  if (!exchange->body->take_over(*unit->body)) {
    exchange->state.store(Exchange::State::not_now, std::memory_order_release);
    return false;
  }
  before_ = std::exchange(unit->body, exchange->body);
  tried_ = static_cast<std::size_t>(unit - periodic_.begin());
  trial_ends_ = unit->block->cycles.load(relaxed) + exchange->runs;
  unit->trial = exchange;
  unit->block->on_trial.store(1, relaxed);
  exchange->row = row_;
  exchange->state.store(Exchange::State::on_trial, std::memory_order_release);  // after `row`
  return true;
}

void Executor::check_trial() noexcept {
  if (periodic_[tried_].block->cycles.load(relaxed) >= trial_ends_) end_trial(Exchange::State::kept);
}

void Executor::end_trial(Exchange::State state) noexcept {
  Unit& unit = periodic_[tried_];
  before_ = nullptr;
  unit.block->on_trial.store(0, relaxed);
  std::exchange(unit.trial, nullptr)
      ->state.store(state, std::memory_order_release);  // after the other members
}

void Executor::put_back(ErrorType type, std::uint64_t cycle, const char* text) noexcept {
  Unit& unit = periodic_[tried_];
  unit.trial->error = type;
  unit.trial->cycle = cycle;
  unit.trial->text.assign(text);
  before_->take_over(*unit.body);
  unit.body = before_;
  end_trial(Exchange::State::put_back);
}

void Executor::record_body(const Unit& unit, std::uint32_t& seen) noexcept {
  const channel::ReleaseSlot& slot = *unit.slot;
  const std::uint32_t done = slot.done.load(std::memory_order_acquire);  // before the load of body_ended_ns
  if (done == seen) return;
  seen = done;
  const std::int64_t ended = slot.body_ended_ns.load(relaxed);
  if (ended == 0) return;  // the process module has not ended any body yet
  rows_.add(channel::FlightKind::body, ended, unit.index, ended - slot.body_began_ns.load(relaxed));
}

Instant Executor::call(const Unit& unit, channel::Activity& activity, channel::FlightWriter& flight,
                       std::uint64_t number, Instant release, Nanoseconds allowed, Instant start) noexcept {
  channel::ModuleBlock& block = *unit.block;
  activity.begin(unit.index, channel::Doing::run, to_ns(start));
  const Outcome outcome =
      unit.body->run({.number = number, .time = release, .period = unit.period, .start = start});
  const Instant end = clock_.now();
  if (!outcome.ok() && unit.trial != nullptr) {  // the old body now serves this release instead
    put_back(outcome.type, number, outcome.text);
    return call(unit, activity, flight, number, release, allowed, end);
  }

  flight.add(channel::FlightKind::run, to_ns(end), unit.index, (end - start).count());
  block.jitter.record((release - start).count());
  block.run.record((end - start).count());
  add(block.cycles);
  const bool overrun = end - release > allowed;
  if (overrun) add(block.overruns);
  if (!outcome.ok()) {
    raise(unit, outcome.type, number, outcome.text);
  } else if (outcome.finished) {
    finish(unit);
  } else if (overrun && fatal(unit)) {
    raise(unit, ErrorType::overrun, number, "run() ended after the module's next release");
  } else if (unit.budget != Nanoseconds{0}) {
    check_budget(unit, number, end - start);
  }
  return end;
}

namespace {
/// Appends a duration, rounded up to a thousandth of its unit, so that a run over its budget does not seem to
/// have met it. Unlike to_text(), allocates no memory.
void append(FixedText<96>& text, Nanoseconds duration) noexcept {
  const bool in_ms = duration >= std::chrono::milliseconds{1};
  const std::int64_t thousandth = in_ms ? 1000 : 1;
  const std::int64_t count = (duration.count() + thousandth - 1) / thousandth;
  text.append(count / 1000);
  std::array<char, 4> decimals{'.', static_cast<char>('0' + count / 100 % 10),
                               static_cast<char>('0' + count / 10 % 10), static_cast<char>('0' + count % 10)};
  std::size_t length = decimals.size();
  while (length > 1 && decimals[length - 1] == '0') --length;
  if (length > 1) text.append(std::string_view{decimals.data(), length});
  text.append(in_ms ? " ms" : " us");
}
}  // namespace

void Executor::check_budget(const Unit& unit, std::uint64_t number, Nanoseconds took) noexcept {
  channel::ModuleBlock& block = *unit.block;
  if (took <= unit.budget) {
    if (unit.tolerance.in_a_row) block.in_a_row.store(0, relaxed);
    return;
  }
  add(block.over_budget);
  const auto& [times, in_a_row] = unit.tolerance;
  FixedText<96> text;
  if (!times && !in_a_row) {
    text.assign("one run() took ");
    append(text, took);
    text.append(", longer than its budget");
    return raise(unit, ErrorType::budget, number, text.c_str());
  }
  if (times && took > unit.budget * *times) {
    text.assign("one run() took ");
    append(text, took);
    text.append(", longer than ");
    text.append(*times);
    text.append(" times its budget");
    return raise(unit, ErrorType::budget, number, text.c_str());
  }
  if (!in_a_row) return;
  const std::uint32_t row = block.in_a_row.load(relaxed) + 1;
  block.in_a_row.store(row, relaxed);
  if (row < static_cast<std::uint32_t>(*in_a_row)) return;
  block.in_a_row.store(0, relaxed);
  text.assign("the last of ");
  text.append(*in_a_row);
  text.append(" runs in a row took ");
  append(text, took);
  text.append(", longer than its budget");
  raise(unit, ErrorType::budget, number, text.c_str());
}

std::uint32_t Executor::check_conditions(Instant release, Instant now) noexcept {
  std::uint32_t wake = 0;
  for (std::size_t i = 0; i < sporadic_count_; ++i) {
    Sporadic& sporadic = sporadic_[i];
    const Unit& unit = sporadic.unit;
    if (!in_tables(unit)) continue;
    if (to_ns(release) < sporadic.not_before_ns.load(relaxed)) continue;

    if (unit.slot != nullptr) {
      record_body(unit, bodies_seen_[periodic_.size() + i]);
      if (unit.immediate) continue;  // the program itself waits for its events
      // The program checks its own condition and deadline. The program gets no release while it is in its
      // body.
      const channel::Release given = channel::release(*unit.slot, row_, to_ns(release));
      if (given == channel::Release::wake) wake |= unit.slot->wake_bit;
      if (given == channel::Release::busy) continue;
      rows_.add(channel::FlightKind::released, to_ns(now), unit.index, static_cast<std::int64_t>(given));
      add(unit.block->cycles);
      sporadic.not_before_ns.store(to_ns(release + unit.interarrival), relaxed);
      continue;
    }

    if (sporadic.ready.load(std::memory_order_acquire) != Ready::no) continue;  // reset by run_sporadic()
    if (unit.immediate) {
      if (unit.body->has_news(now)) wake |= channel::kSporadicBit;
      continue;
    }
    bool ready = false;
    block_.row.begin(unit.index, channel::Doing::condition, to_ns(release));
    const Outcome outcome =
        unit.body->condition({.number = row_, .time = release, .period = unit.period, .start = now}, &ready);
    if (!outcome.ok()) {
      raise(unit, outcome.type, row_, outcome.text);
    } else if (ready) {
      rows_.add(channel::FlightKind::ready, to_ns(now), unit.index);
      make_ready(sporadic, release, row_);
      wake |= channel::kSporadicBit;
    }
  }
  return wake;
}

void Executor::make_ready(Sporadic& sporadic, Instant release, std::uint64_t cycle) noexcept {
  sporadic.release_ns = to_ns(release);
  sporadic.deadline_ns = to_ns(release + sporadic.unit.deadline);
  sporadic.cycle = cycle;
  sporadic.not_before_ns.store(to_ns(release + sporadic.unit.interarrival), relaxed);
  sporadic.ready.store(Ready::yes, std::memory_order_release);  // after the members above
}

// Checks the conditions of the modules with immediate dispatch, and makes those ready whose condition is
// true. Only the sporadic thread calls this function. The thread of the rows only checks whether there are
// unread events, and then wakes the sporadic thread.
void Executor::release_immediate() noexcept {
  for (std::size_t i = 0; i < sporadic_count_; ++i) {
    Sporadic& sporadic = sporadic_[i];
    const Unit& unit = sporadic.unit;
    if (!unit.immediate || unit.body == nullptr || sporadic.ready.load(relaxed) != Ready::no) continue;
    const Instant now = clock_.now();
    if (!unit.body->has_news(now)) continue;
    if (to_ns(now) < sporadic.not_before_ns.load(relaxed))
      // The minimum interarrival time has not passed yet. A later row wakes this thread again for the module.
      continue;
    block_.sporadic.announce(unit.index, channel::Doing::condition, to_ns(now));  // must precede in_tables()
    if (in_tables(unit)) {
      const std::uint64_t row = block_.next_row.load(relaxed);
      bool ready = false;
      const Outcome outcome =
          unit.body->condition({.number = row, .time = now, .period = unit.period, .start = now}, &ready);
      if (!outcome.ok()) {
        raise(unit, outcome.type, row, outcome.text);
      } else if (ready) {
        runs_.add(channel::FlightKind::ready, to_ns(now), unit.index);
        make_ready(sporadic, now, row);
      }
    }
    block_.sporadic.end();
  }
}

bool Executor::run_sporadic() noexcept {
  if (has_immediate_) release_immediate();
  Sporadic* first = nullptr;
  for (std::size_t i = 0; i < sporadic_count_; ++i) {
    Sporadic& candidate = sporadic_[i];
    if (candidate.ready.load(std::memory_order_acquire) != Ready::yes) continue;  // make_ready() sets yes
    if (first == nullptr || candidate.deadline_ns < first->deadline_ns) first = &candidate;
  }
  if (first == nullptr) return false;

  const Unit& unit = first->unit;
  const Instant start = clock_.now();
  block_.sporadic.announce(unit.index, channel::Doing::run,
                           to_ns(start));  // must precede in_tables()
  if (in_tables(unit)) {
    const Instant end =
        call(unit, block_.sporadic, runs_, first->cycle, from_ns(first->release_ns), unit.deadline, start);
    const Nanoseconds late = end - from_ns(first->deadline_ns);
    if (unit.late_is_error && late > Nanoseconds{0} && in_tables(unit)) raise_late(unit, first->cycle, late);
  }
  block_.sporadic.end();
  first->ready.store(Ready::no, std::memory_order_release);
  return true;
}

void Executor::raise_missed(const Unit& unit, std::uint64_t cycle, std::uint64_t releases) noexcept {
  FixedText<96> text;
  text.append(static_cast<std::int64_t>(releases));
  text.append(releases == 1 ? " release was missed, number " : " releases were missed, from number ");
  text.append(static_cast<std::int64_t>(cycle));
  text.append(releases == 1 ? "" : " on");
  raise(unit, ErrorType::overrun, cycle, text.c_str());
}

void Executor::raise_late(const Unit& unit, std::uint64_t cycle, Nanoseconds by) noexcept {
  FixedText<64> text;
  text.assign("run() ended ");
  text.append(by.count() / 1000);
  text.append(" us after its deadline");
  raise(unit, ErrorType::deadline, cycle, text.c_str());
}

// Removes a module that has finished its work from the tables. Then the supervisor moves the module to
// DESTRUCT.
void Executor::finish(const Unit& unit) noexcept {
  if (unit.trial != nullptr) end_trial(Exchange::State::kept);
  unit.block->in_tables.store(0, std::memory_order_seq_cst);
  unit.block->finished.store(1, std::memory_order_release);
}

void Executor::raise(const Unit& unit, ErrorType type, std::uint64_t cycle, const char* text) noexcept {
  if (unit.trial != nullptr) {
    put_back(type, cycle, text);
    if (type != ErrorType::overrun) return;  // the old body is back, but an overrun remains an error
  }
  channel::ModuleBlock& block = *unit.block;
  block.in_tables.store(0, std::memory_order_seq_cst);
  add(block.errors);
  block.error_cycle.store(cycle, relaxed);
  block.error_text.assign(text);
  block.error.store(static_cast<std::uint32_t>(type), std::memory_order_release);  // after error_text
}

}  // namespace takt::executor
