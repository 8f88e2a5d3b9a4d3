// libtakt_process: the other side of channel/seat.hpp, inside the user's own program.
#include <cstdio>
#include <cstdlib>

#include <takt/component/process.h>
#include <takt/channel/seat.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/real_time.hpp>
#include <takt/os/shared_memory.hpp>
#include <takt/os/waker.hpp>

namespace {

using namespace takt;

/// This program's place in the scheduler, from the first line of main to its end.
class Guest {
 public:
  void attach(channel::SeatKind kind, const char* function);
  void wait(const char* function);

  [[nodiscard]] const channel::Seat* seat() const { return seat_; }

 private:
  [[noreturn]] static void refuse(const char* function, const char* what);
  bool released() const {
    return seat_->released.load(std::memory_order_acquire) != taken_;
  }  // SYNC: released
  void body_done();
  void spin_until_release();
  void sleep_on_bell();
  void end_if_told() const;

  os::SharedMemory seat_memory_;
  os::SharedMemory bell_memory_;
  channel::Seat* seat_ = nullptr;
  channel::Bell* bell_ = nullptr;
  os::WakeMargin margin_{Nanoseconds{0}};
  std::uint32_t taken_ = 0;
  Instant started_{};
};

void Guest::refuse(const char* function, const char* what) {
  std::fprintf(stderr, "takt: %s(): %s\n", function, what);
  std::exit(1);
}

void Guest::attach(channel::SeatKind kind, const char* function) {
  // Lines are to be seen when they are written, also through a pipe.
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (seat_ != nullptr) refuse(function, "called twice; call it once, before the first wait");
  os::Fd seat = os::take_fd_from_environment("TAKT_SEAT_FD");
  os::Fd bell = os::take_fd_from_environment("TAKT_BELL_FD");
  if (!seat || !bell)
    refuse(function, "this program was not started by takt-node; name it in a descriptor and run that");
  auto seat_memory = os::SharedMemory::attach(std::move(seat));
  auto bell_memory = os::SharedMemory::attach(std::move(bell));
  if (!seat_memory || !bell_memory) refuse(function, "the memory shared with takt-node cannot be mapped");
  seat_memory_ = std::move(*seat_memory);
  bell_memory_ = std::move(*bell_memory);
  seat_ = reinterpret_cast<channel::Seat*>(seat_memory_.data());
  bell_ = reinterpret_cast<channel::Bell*>(bell_memory_.data());
  if (seat_memory_.size() < sizeof(channel::Seat) || seat_->magic != channel::Seat::kMagic) {
    refuse(function, "takt-node is of another version than libtakt_process");
  }
  if (seat_->kind != kind) {
    refuse(function, seat_->kind == channel::SeatKind::periodic
                         ? "the descriptor says periodic; use initPeriodExe() and waitPeriod()"
                     : seat_->kind == channel::SeatKind::sporadic
                         ? "the descriptor says sporadic; use initSporadicExe() and waitSporadic()"
                         : "the descriptor says non-real; such a program is not released and needs no call");
  }
  margin_ = os::WakeMargin{Nanoseconds{seat_->margin_cap_ns}};
  if (seat_->lock_memory != 0) static_cast<void>(os::lock_memory());
  seat_->thread.store(os::thread_id(), std::memory_order_relaxed);
  seat_->phase.store(channel::SeatPhase::attached, std::memory_order_release);
}

void Guest::end_if_told() const {
  if (seat_->end.load(std::memory_order_acquire) != 0) std::exit(0);
}

// The release is expected one period after the last. It comes a little later than its instant, after the
// modules before it in the row, so the spin goes on for as long behind the instant as the margin may be
// before it.
void Guest::spin_until_release() {
  const Instant expected = from_ns(seat_->release_ns.load(std::memory_order_relaxed) + seat_->period_ns);
  const Instant wake = expected - margin_.value();
  const Instant patience = expected + Nanoseconds{seat_->margin_cap_ns};
  Instant now = os::now();
  if (now < wake) {
    os::sleep_until(wake);
    now = os::now();
    margin_.observe(now - wake);
    seat_->margin_ns.store(margin_.value().count(), std::memory_order_relaxed);
  }
  while (!released() && now < patience) {
    os::cpu_relax();
    now = os::now();
  }
}

void Guest::sleep_on_bell() {
  const std::uint32_t rings = bell_->rings.load(std::memory_order_seq_cst);
  seat_->sleeping.store(1, std::memory_order_seq_cst);  // SYNC: sleeping
  if (seat_->released.load(std::memory_order_seq_cst) == taken_ &&
      seat_->end.load(std::memory_order_seq_cst) == 0) {
    os::futex_wait(bell_->rings, rings, seat_->bell_bit);
  }
  seat_->sleeping.store(0, std::memory_order_seq_cst);
}

void Guest::body_done() {
  const Instant now = os::now();
  seat_->run.record((now - started_).count());
  if (seat_->deadline_ns == 0) return;
  const std::int64_t late =
      to_ns(now) - seat_->release_ns.load(std::memory_order_relaxed) - seat_->deadline_ns;
  if (late <= 0) return;
  seat_->late_by_ns.store(late, std::memory_order_relaxed);
  seat_->late.fetch_add(1, std::memory_order_release);  // SYNC: late
}

void Guest::wait(const char* function) {
  if (seat_ == nullptr) refuse(function, "call initPeriodExe() or initSporadicExe() first");
  if (taken_ != 0) body_done();
  seat_->done.store(taken_, std::memory_order_release);  // SYNC: done
  if (taken_ == 0) seat_->phase.store(channel::SeatPhase::ready, std::memory_order_release);

  end_if_told();
  if (taken_ != 0 && !released()) spin_until_release();
  while (!released()) {
    end_if_told();
    sleep_on_bell();
  }
  taken_ = seat_->released.load(std::memory_order_acquire);
  started_ = os::now();
  seat_->jitter.record(seat_->release_ns.load(std::memory_order_relaxed) - to_ns(started_));
}

Guest guest;

}  // namespace

extern "C" {

void initPeriodExe(void) { guest.attach(channel::SeatKind::periodic, "initPeriodExe"); }
void initSporadicExe(void) { guest.attach(channel::SeatKind::sporadic, "initSporadicExe"); }
void waitPeriod(void) { guest.wait("waitPeriod"); }
void waitSporadic(void) { guest.wait("waitSporadic"); }

uint64_t takt_cycle(void) {
  return guest.seat() == nullptr ? 0 : guest.seat()->cycle.load(std::memory_order_relaxed);
}
int64_t takt_release_ns(void) {
  return guest.seat() == nullptr ? 0 : guest.seat()->release_ns.load(std::memory_order_relaxed);
}
int64_t takt_period_ns(void) { return guest.seat() == nullptr ? 0 : guest.seat()->period_ns; }
}
