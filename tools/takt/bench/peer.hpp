// The other process of a measurement: this program, started again with a hidden command.
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

/// The memory that both see. The answers follow it.
struct Mailbox {
  WakeBy by = WakeBy::futex;
  std::int32_t cpu = 0;
  std::int32_t priority = 0;
  std::atomic<std::uint32_t> refused{0};    ///< the priority or the processor
  std::atomic<std::uint32_t> ready{0};      ///< it waits
  std::atomic<std::uint32_t> end{0};        ///< it is to end when it is woken next
  std::atomic<std::uint32_t> sent{0};       ///< SYNC: release sent; how often it was woken, and the futex
  std::atomic<std::int64_t> release_ns{0};  ///< of that
  std::atomic<std::uint32_t> answered{0};   ///< SYNC: release answered; the releases whose body began
};

/// A program that waits to be woken, and says when it was.
class Peer {
 public:
  /// At this place; with room for so many answers.
  static Result<Peer> start(WakeBy by, const Place& place, std::size_t most);
  Peer(Peer&&) = default;
  Peer& operator=(Peer&&) = delete;
  /// Ends it.
  ~Peer();

  /// Wakes it for this release unless it still has not answered the one before; false then. Real-time, one
  /// system call.
  bool wake(Instant release) noexcept;
  /// The jitter of each answer, release minus start in ns, in their order. When nobody wakes it any more.
  [[nodiscard]] std::vector<std::int64_t> jitter() const;
  [[nodiscard]] bool refused() const noexcept { return mailbox().refused.load() != 0; }

 private:
  Peer(os::SharedMemory memory, os::Child child) : memory_(std::move(memory)), child_(std::move(child)) {}
  [[nodiscard]] Mailbox& mailbox() const noexcept { return *reinterpret_cast<Mailbox*>(memory_.data()); }
  void knock() noexcept;

  os::SharedMemory memory_;
  os::Child child_;
};

/// What the peer does; the exit status.
int serve_as_peer();

}  // namespace takt::bench
