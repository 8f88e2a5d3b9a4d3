// Passes the newest value from one thread to another without waiting, for example between the cyclic body of
// a process module and its network thread.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

/// A triple buffer: the writer owns one slot, the reader owns one, and they exchange the third. Before each
/// publish(), overwrite the whole slot that writing() returns, because the slot holds an older value. The
/// writer and the reader may be real-time threads.
template <class T>
class Latest {
 public:
  /// The writer fills this slot and then calls publish().
  [[nodiscard]] T& writing() noexcept { return slots_[write_]; }
  void publish() noexcept {
    // This exchange synchronizes with take(). Release: a reader that takes the slot sees the written value.
    // Acquire: the reader has finished with the slot that the exchange returns.
    write_ = static_cast<std::uint8_t>(
        middle_.exchange(static_cast<std::uint8_t>(write_ | kNew), std::memory_order_acq_rel) & kSlot);
  }

  /// For the reader: makes taken() return the newest value. Returns false if no value was published since the
  /// last take().
  bool take() noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kNew) == 0) return false;
    read_ = static_cast<std::uint8_t>(middle_.exchange(read_, std::memory_order_acq_rel) &
                                      kSlot);  // synchronizes with publish()
    return true;
  }
  /// For the reader: the value of the last successful take(); T{} before the first.
  [[nodiscard]] const T& taken() const noexcept { return slots_[read_]; }

 private:
  static constexpr std::uint8_t kSlot = 3;
  static constexpr std::uint8_t kNew = 4;

  std::array<T, 3> slots_{};
  std::uint8_t write_ = 0;
  std::uint8_t read_ = 1;
  std::atomic<std::uint8_t> middle_{2};
};
