// The second process of a measurement, which is `takt` with a hidden command.
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

/// How the first process wakes the peer.
enum class WakeBy : std::uint32_t { futex, signal };

/// The beginning of the memory that both processes share. The peer's answers are stored after the mailbox.
struct Mailbox {
  WakeBy by = WakeBy::futex;
  std::int32_t cpu = 0;
  std::int32_t priority = 0;
  std::atomic<std::uint32_t> refused{0};  ///< the system denied the peer its priority or CPU
  std::atomic<std::uint32_t> ready{0};    ///< the peer waits for a wake-up
  std::atomic<std::uint32_t> end{0};      ///< the peer must end at its next wake-up
  std::atomic<std::uint32_t> sent{
      0};  ///< number of wake-ups that the first process has sent; also used as the futex
  std::atomic<std::int64_t> release_ns{0};  ///< time of the newest release
  std::atomic<std::uint32_t> answered{0};   ///< number of releases that the peer has answered
};

/// A process that waits for wake-ups and records the time of each.
class Peer {
 public:
  /// Starts the second process with this CPU and priority, and allocates memory for `most` answers.
  static Result<Peer> start(WakeBy by, const Scheduling& scheduling, std::size_t most);
  Peer(Peer&&) = default;
  Peer& operator=(Peer&&) = delete;
  /// Ends the second process.
  ~Peer();

  /// Wakes the second process for this release. Returns false, without waking it, if it has not answered the
  /// previous release. A real-time thread may call this function, which makes one system call.
  bool wake(Instant release) noexcept;
  /// The jitter of each answer in order: release minus start, in ns. Call this only after the last wake().
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
