// The newest value of one thread for one other, for two that may not wait for each other: the cyclic body of
// a program and the thread that talks to the network.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

/// Three slots: one is being written, one is being read, and the third changes hands. T is filled anew before
/// each publish(): what writing() holds then is of an earlier turn. Real-time for both sides.
template <class T>
class Latest {
 public:
  /// The writer's.
  [[nodiscard]] T& writing() noexcept { return slots_[write_]; }
  void publish() noexcept {
    // SYNC: latest published. Release: what was written is seen by whoever takes it; acquire: the reader has
    // done with the slot that comes back.
    write_ = static_cast<std::uint8_t>(
        middle_.exchange(static_cast<std::uint8_t>(write_ | kNew), std::memory_order_acq_rel) & kSlot);
  }

  /// The reader's: true when something was published since the last take().
  bool take() noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kNew) == 0) return false;
    read_ = static_cast<std::uint8_t>(middle_.exchange(read_, std::memory_order_acq_rel) &
                                      kSlot);  // SYNC: latest published
    return true;
  }
  /// What was taken last; T{} before the first.
  [[nodiscard]] const T& taken() const noexcept { return slots_[read_]; }

 private:
  static constexpr std::uint8_t kSlot = 3;
  static constexpr std::uint8_t kNew = 4;

  std::array<T, 3> slots_{};
  std::uint8_t write_ = 0;
  std::uint8_t read_ = 1;
  std::atomic<std::uint8_t> middle_{2};
};
