#include "kernel.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include <takt/core/check.hpp>

namespace takt::simulation {

Kernel::~Kernel() = default;

Strand& Kernel::spawn(const Place& place, std::function<void()> body) {
  strands_.push_back(std::unique_ptr<Strand>(new Strand));
  Strand& strand = *strands_.back();
  strand.processor_ = place.processor == nullptr ? &strand.own_ : place.processor;
  strand.priority_ = place.priority;
  strand.fiber_ = std::make_unique<os::Fiber>(kStackBytes, [this, body = std::move(body)] {
    body();
    end();
  });
  want(strand, Nanoseconds{0});
  return strand;
}

void Kernel::kill(Strand& strand) {
  TAKT_CHECK(&strand != running_);
  if (strand.ended_) return;
  strand.ended_ = true;
  strand.waits_ = false;
  want_no_more(strand);
  dead_.push_back(&strand);
}

void Kernel::end() {
  Strand& strand = *running_;
  strand.ended_ = true;
  want_no_more(strand);
  dead_.push_back(&strand);
  pass_on();
  std::abort();  // nobody hands over to it
}

void Kernel::work(Nanoseconds time) {
  if (time <= Nanoseconds{0}) return;
  Strand& strand = *running_;
  strand.left_ = time;
  strand.processor_->has_ = nullptr;  // whoever came meanwhile may go first
  decide(*strand.processor_);
  pass_on();
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
  want_no_more(strand);
  pass_on();
  return strand.woken_;
}

void Kernel::wake(Strand& strand, Nanoseconds delay) {
  if (!strand.waits_ || strand.woken_) return;
  strand.woken_ = true;  // once
  ++strand.wait_;        // it is not ended by its time any more
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

void Kernel::want(Strand& strand, Nanoseconds work) {
  strand.left_ = work;
  strand.wants_since_ = wants_++;
  strand.processor_->wanted_by_.push_back(&strand);
  decide(*strand.processor_);
}

void Kernel::want_no_more(Strand& strand) {
  Processor& processor = *strand.processor_;
  std::erase(processor.wanted_by_, &strand);
  if (processor.has_ == &strand) processor.has_ = nullptr;
  decide(processor);
}

// Who has the processor from now on, and when that one's work is done.
void Kernel::decide(Processor& processor) {
  const auto first = std::min_element(
      processor.wanted_by_.begin(), processor.wanted_by_.end(), [](const Strand* a, const Strand* b) {
        return a->priority_ != b->priority_ ? a->priority_ > b->priority_ : a->wants_since_ < b->wants_since_;
      });
  Strand* const best = first == processor.wanted_by_.end() ? nullptr : *first;
  if (processor.has_ != nullptr && processor.has_ == best) return;
  // The one that runs now has said nothing yet of its next work.
  if (processor.has_ != nullptr && processor.has_ == running_) return;
  if (processor.has_ != nullptr) processor.has_->left_ -= now_ - processor.since_;
  processor.has_ = best;
  processor.since_ = now_;
  ++processor.turn_;
  if (best == nullptr) return;
  push({.when = now_ + best->left_,
        .order = 0,
        .strand = best,
        .valid = processor.turn_,
        .is_wake = false,
        .call = 0});
}

bool Kernel::is_void(const Event& event) const noexcept {
  if (event.strand == nullptr) return false;
  if (event.strand->ended_) return true;
  if (event.is_wake) return !event.strand->waits_ || event.strand->wait_ != event.valid;
  return event.strand->processor_->has_ != event.strand || event.strand->processor_->turn_ != event.valid;
}

bool Kernel::next(Event& event) {
  while (!events_.empty()) {
    event = events_.top();
    if (is_void(event)) {
      events_.pop();
      continue;
    }
    if (event.when > end_) return false;
    if (event.strand == nullptr) return true;  // for who is no strand
    events_.pop();
    now_ = event.when;
    if (!event.is_wake) return true;
    event.strand->waits_ = false;
    want(*event.strand, Nanoseconds{0});
  }
  return false;
}

// The running strand has nothing to do at present: whoever comes next goes on, perhaps itself.
void Kernel::pass_on() {
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
  // Whoever handed over has said that we run.
}

void Kernel::go_to(Strand& strand) {
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
      go_to(*event.strand);
    } else {
      events_.pop();
      now_ = event.when;
      const std::function<void()> call = std::move(calls_[event.call]);
      free_calls_.push_back(event.call);
      call();
    }
    // No strand's stack is in use here.
    for (Strand* dead : dead_) dead->fiber_.reset();
    dead_.clear();
  }
  now_ = std::max(now_, end);
}

}  // namespace takt::simulation
