// The second process of a measurement: this program, started again with a hidden command.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/os/process.hpp>
#include <takt/os/shared_memory.hpp>

#include "bare_loop.hpp"

namespace takt::bench {

/// How the peer is woken.
enum class WakeBy : std::uint32_t { futex, signal };

/// The shared memory of both processes begins with this. The answers follow it.
struct Mailbox {
  WakeBy by = WakeBy::futex;
  std::int32_t cpu = 0;
  std::int32_t priority = 0;
  std::atomic<std::uint32_t> refused{0};    ///< the system denied the priority or the CPU
  std::atomic<std::uint32_t> ready{0};      ///< the peer waits
  std::atomic<std::uint32_t> end{0};        ///< the peer must end at the next wake-up
  std::atomic<std::uint32_t> sent{0};       ///< SYNC: release sent; number of wake-ups, also the futex
  std::atomic<std::int64_t> release_ns{0};  ///< time of the last release
  std::atomic<std::uint32_t> answered{0};   ///< SYNC: release answered; number of releases whose body began
};

/// A process that waits for wake-ups and records when each arrived.
class Peer {
 public:
  /// Starts the process at this place, with room for `most` answers.
  static Result<Peer> start(WakeBy by, const Place& place, std::size_t most);
  Peer(Peer&&) = default;
  Peer& operator=(Peer&&) = delete;
  /// Ends the process.
  ~Peer();

  /// Wakes the process for this release. Returns false and does not wake it if it has not answered the
  /// previous release. Real-time, one system call.
  bool wake(Instant release) noexcept;
  /// The jitter of each answer, release minus start in ns, in order. Call it after the last wake().
  [[nodiscard]] std::vector<std::int64_t> jitter() const;
  [[nodiscard]] bool refused() const noexcept { return mailbox().refused.load() != 0; }

 private:
  Peer(os::SharedMemory memory, os::Child child) : memory_(std::move(memory)), child_(std::move(child)) {}
  [[nodiscard]] Mailbox& mailbox() const noexcept { return *reinterpret_cast<Mailbox*>(memory_.data()); }
  void knock() noexcept;

  os::SharedMemory memory_;
  os::Child child_;
};

/// The main function of the second process. Returns the exit status.
int serve_as_peer();

}  // namespace takt::bench
