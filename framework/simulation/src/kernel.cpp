#include "kernel.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include <takt/core/check.hpp>

namespace takt::simulation {

Kernel::~Kernel() = default;

Strand& Kernel::spawn(const Scheduling& scheduling, std::function<void()> body) {
  strands_.push_back(std::unique_ptr<Strand>(new Strand));
  Strand& strand = *strands_.back();
  strand.id_ = static_cast<std::int32_t>(strands_.size());
  strand.cpu_ = scheduling.cpu == nullptr ? &strand.own_ : scheduling.cpu;
  strand.priority_ = scheduling.priority;
  strand.fiber_ = std::make_unique<os::Fiber>(kStackBytes, [this, body = std::move(body)] {
    body();
    end();
  });
  make_ready(strand, Nanoseconds{0});
  return strand;
}

void Kernel::kill(Strand& strand) {
  TAKT_CHECK(&strand != running_);
  if (strand.ended_) return;
  strand.ended_ = true;
  strand.waits_ = false;
  make_not_ready(strand);
  dead_.push_back(&strand);
}

void Kernel::end() {
  Strand& strand = *running_;
  strand.ended_ = true;
  make_not_ready(strand);
  dead_.push_back(&strand);
  switch_to_next();
  std::abort();  // an ended strand never runs again
}

void Kernel::work(Nanoseconds time) {
  if (time <= Nanoseconds{0}) return;
  Strand& strand = *running_;
  preempt(*strand.cpu_);  // a strand that became ready meanwhile may run first
  strand.left_ = time;
  reschedule(*strand.cpu_);
  switch_to_next();
}

void Kernel::sleep_until(Instant until) {
  if (until > now_) static_cast<void>(wait(until));
}

bool Kernel::wait(Instant until) {
  Strand& strand = *running_;
  strand.waits_ = true;
  strand.woken_ = false;
  ++strand.wait_;
  if (until != Instant::max()) {
    push({.when = std::max(until, now_),
          .order = 0,
          .strand = &strand,
          .valid = strand.wait_,
          .is_wake = true,
          .call = 0});
  }
  make_not_ready(strand);
  switch_to_next();
  return strand.woken_;
}

void Kernel::wake(Strand& strand, Nanoseconds delay) {
  if (!strand.waits_ || strand.woken_) return;
  strand.woken_ = true;  // so that further calls of wake() have no effect
  ++strand.wait_;        // makes the event at the end of the strand's waiting time outdated
  push({.when = now_ + delay,
        .order = 0,
        .strand = &strand,
        .valid = strand.wait_,
        .is_wake = true,
        .call = 0});
}

void Kernel::at(Instant when, std::function<void()> call) {
  std::size_t index = calls_.size();
  if (free_calls_.empty()) {
    calls_.push_back(std::move(call));
  } else {
    index = free_calls_.back();
    free_calls_.pop_back();
    calls_[index] = std::move(call);
  }
  push({.when = std::max(when, now_),
        .order = 0,
        .strand = nullptr,
        .valid = 0,
        .is_wake = false,
        .call = index});
}

void Kernel::push(Event event) {
  event.order = order_++;
  events_.push(event);
}

void Kernel::make_ready(Strand& strand, Nanoseconds work) {
  strand.left_ = work;
  strand.ready_order_ = ready_count_++;
  strand.cpu_->ready_.push_back(&strand);
  reschedule(*strand.cpu_);
}

void Kernel::make_not_ready(Strand& strand) {
  Cpu& cpu = *strand.cpu_;
  std::erase(cpu.ready_, &strand);
  if (cpu.current_ == &strand) preempt(cpu);
  reschedule(cpu);
}

void Kernel::preempt(Cpu& cpu) {
  if (cpu.current_ == nullptr) return;
  const Nanoseconds ran = now_ - cpu.since_;
  cpu.current_->left_ -= ran;
  cpu.current_->ran_ += ran;
  cpu.current_ = nullptr;
}

std::optional<Nanoseconds> Kernel::ran_if_ready(std::int32_t id) const noexcept {
  if (id < 1 || static_cast<std::size_t>(id) > strands_.size()) return std::nullopt;
  const Strand& strand = *strands_[static_cast<std::size_t>(id) - 1];
  if (strand.ended_ || strand.waits_) return std::nullopt;
  return strand.ran_ + (strand.cpu_->current_ == &strand ? now_ - strand.cpu_->since_ : Nanoseconds{0});
}

// Chooses the strand that runs from now on, and schedules the end of its work.
void Kernel::reschedule(Cpu& cpu) {
  const auto first =
      std::min_element(cpu.ready_.begin(), cpu.ready_.end(), [](const Strand* a, const Strand* b) {
        return a->priority_ != b->priority_ ? a->priority_ > b->priority_ : a->ready_order_ < b->ready_order_;
      });
  Strand* const best = first == cpu.ready_.end() ? nullptr : *first;
  if (cpu.current_ != nullptr && cpu.current_ == best) return;
  // The running strand keeps the CPU until it calls work() or waits.
  if (cpu.current_ != nullptr && cpu.current_ == running_) return;
  preempt(cpu);
  cpu.current_ = best;
  cpu.since_ = now_;
  ++cpu.turn_;
  if (best == nullptr) return;
  push({.when = now_ + best->left_,
        .order = 0,
        .strand = best,
        .valid = cpu.turn_,
        .is_wake = false,
        .call = 0});
}

bool Kernel::is_outdated(const Event& event) const noexcept {
  if (event.strand == nullptr) return false;
  if (event.strand->ended_) return true;
  if (event.is_wake) return !event.strand->waits_ || event.strand->wait_ != event.valid;
  return event.strand->cpu_->current_ != event.strand || event.strand->cpu_->turn_ != event.valid;
}

bool Kernel::next(Event& event) {
  while (!events_.empty()) {
    event = events_.top();
    if (is_outdated(event)) {
      events_.pop();
      continue;
    }
    if (event.when > end_) return false;
    if (event.strand == nullptr) return true;  // the event is a function to call, not a strand
    events_.pop();
    now_ = event.when;
    if (!event.is_wake) return true;
    event.strand->waits_ = false;
    make_ready(*event.strand, Nanoseconds{0});
  }
  return false;
}

// Called when the running strand works, waits or ends. Switches to the strand of the next event, which may be
// the same strand.
void Kernel::switch_to_next() {
  Strand& strand = *running_;
  Event event{};
  running_ = nullptr;
  const bool found = next(event);
  if (found && event.strand == &strand) {
    running_ = &strand;
    return;
  }
  if (found && event.strand != nullptr) {
    running_ = event.strand;
    strand.fiber_->hand_over_to(*event.strand->fiber_);
  } else {
    strand.fiber_->hand_over_to(main_);
  }
  // When another fiber switches back to this strand, it has already set running_ to this strand.
}

void Kernel::resume(Strand& strand) {
  running_ = &strand;
  main_.hand_over_to(*strand.fiber_);
  running_ = nullptr;
}

void Kernel::run_until(Instant end) {
  TAKT_CHECK(running_ == nullptr);
  end_ = end;
  Event event{};
  while (next(event)) {
    if (event.strand != nullptr) {
      resume(*event.strand);
    } else {
      events_.pop();
      now_ = event.when;
      const std::function<void()> call = std::move(calls_[event.call]);
      free_calls_.push_back(event.call);
      call();
    }
    // At this point, no strand's stack is in use.
    for (Strand* dead : dead_) dead->fiber_.reset();
    dead_.clear();
  }
  now_ = std::max(now_, end);
}

}  // namespace takt::simulation
