#include "peer.hpp"

#include <new>

#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/real_time.hpp>
#include <takt/os/wake_signal.hpp>

namespace takt::bench {

namespace {

using namespace std::chrono_literals;

constexpr const char* kMailboxFd = "TAKT_BENCH_MAILBOX_FD";

std::int64_t* answers_in(const os::SharedMemory& memory) {
  return reinterpret_cast<std::int64_t*>(memory.data() + sizeof(Mailbox));
}
std::size_t room_in(const os::SharedMemory& memory) {
  return (memory.size() - sizeof(Mailbox)) / sizeof(std::int64_t);
}

void answer_until_the_end(Mailbox& mailbox, std::int64_t* answers, std::size_t room) {
  std::uint32_t seen = 0;
  mailbox.ready.store(1, std::memory_order_release);
  while (true) {
    if (mailbox.by == WakeBy::signal) {
      os::wait_for_wake_signal();
    } else {
      while (mailbox.sent.load(std::memory_order_acquire) == seen) os::futex_wait(mailbox.sent, seen, ~0U);
    }
    const Instant now = os::now();
    if (mailbox.end.load(std::memory_order_acquire) != 0) return;
    seen = mailbox.sent.load(std::memory_order_acquire);  // synchronizes with knock()
    const std::uint32_t count = mailbox.answered.load(std::memory_order_relaxed);
    if (count < room) answers[count] = mailbox.release_ns.load(std::memory_order_relaxed) - to_ns(now);
    mailbox.answered.store(count + 1, std::memory_order_release);  // synchronizes with wake()
  }
}

}  // namespace

Result<Peer> Peer::start(WakeBy by, const Scheduling& scheduling, std::size_t most) {
  auto memory = os::SharedMemory::create("takt-bench", sizeof(Mailbox) + most * sizeof(std::int64_t));
  if (!memory) return memory.problems();
  auto* mailbox = new (memory->data()) Mailbox{};
  mailbox->by = by;
  mailbox->cpu = scheduling.cpu;
  mailbox->priority = scheduling.priority;
  auto child = os::Child::spawn({.program = os::program_directory() + "/takt",
                                 .arguments = {"bench", "peer"},
                                 .environment = {{kMailboxFd, std::to_string(memory->fd().get())}},
                                 .inherit = {&memory->fd()}});
  if (!child) return child.problems();
  Peer peer{std::move(*memory), std::move(*child)};
  for (const Instant limit = os::now() + 10s; peer.mailbox().ready.load() == 0;) {
    os::sleep_until(os::now() + 1ms);
    if (os::now() > limit || peer.child_.poll())
      return fail("the second process of the measurement did not become ready");
  }
  return peer;
}

Peer::~Peer() {
  if (!child_.running()) return;
  mailbox().end.store(1, std::memory_order_release);
  knock();
  child_.wait();
}

void Peer::knock() noexcept {
  mailbox().sent.fetch_add(1, std::memory_order_release);  // synchronizes with answer_until_the_end()
  if (mailbox().by == WakeBy::signal)
    os::send_wake_signal(child_.pid());
  else
    os::futex_wake(mailbox().sent, ~0U);
}

bool Peer::wake(Instant release) noexcept {
  Mailbox& box = mailbox();
  if (box.answered.load(std::memory_order_acquire) != box.sent.load(std::memory_order_relaxed)) return false;
  box.release_ns.store(to_ns(release), std::memory_order_relaxed);
  knock();
  return true;
}

std::vector<std::int64_t> Peer::jitter() const {
  const std::size_t count =
      std::min<std::size_t>(mailbox().answered.load(std::memory_order_acquire), room_in(memory_));
  return {answers_in(memory_), answers_in(memory_) + count};
}

int serve_as_peer() {
  auto memory = os::SharedMemory::attach(os::take_fd_from_environment(kMailboxFd));
  if (!memory || memory->size() < sizeof(Mailbox)) return 1;
  auto& mailbox = *reinterpret_cast<Mailbox*>(memory->data());
  os::hold_wake_signal();
  Problems refused;
  if (const auto locked = os::lock_memory(); !locked) refused = locked.problems();
  auto thread = os::Thread::start(
      {.name = "peer", .priority = mailbox.priority, .cpus = {mailbox.cpu}},
      [&] { answer_until_the_end(mailbox, answers_in(*memory), room_in(*memory)); }, &refused);
  if (!thread) return 1;
  if (!refused.empty()) mailbox.refused.store(1);
  thread->join();
  return 0;
}

}  // namespace takt::bench
