// A part of the release slot: the node asks the program of a process module for the value of a property, or
// sets a property, while the program runs.
//
// There is one request at a time. The node writes the request and increments its number. A thread of the
// program sleeps on this number, carries out the request, and writes the answer with the same number. The
// node sends the next request only after this answer. So neither side ever reads what the other side is
// writing. A program can write only the answer, and the node never waits for it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include <takt/core/fixed_text.hpp>

namespace takt::channel {

/// The request. The node writes it.
struct PropertyRequest {
  static constexpr std::size_t kMostName = 63;    ///< the most bytes of a property's name
  static constexpr std::size_t kMostValue = 255;  ///< the most bytes of a value to set

  std::atomic<std::uint32_t> number;  ///< number of the request; stored after the other members
  std::uint32_t sets;                 ///< 1: set the property to `value`; 0: get its value
  FixedText<kMostName + 1> name;
  FixedText<kMostValue + 1> value;

  /// Writes the next request. The thread of the program must then be woken, see os::futex_wake(). The node
  /// calls ask() only after the answer to the request before.
  void ask(bool to_set, std::string_view property, std::string_view to) noexcept {
    sets = to_set ? 1 : 0;
    name.assign(property);
    value.assign(to);
    // Pairs with the load in the program's thread: a thread that sees the number sees the whole request.
    number.store(number.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }
};

/// The answer. The program writes it, so the node must check what it reads.
struct PropertyAnswer {
  static constexpr std::size_t kMostText = 511;  ///< the rest of a longer text is cut off

  std::atomic<std::uint32_t> serves;  ///< 1: the program declares properties, and a thread answers requests
  std::atomic<std::uint32_t> number;  ///< number of the answered request; stored after the other members
  std::uint32_t ok;                   ///< 1: carried out; 0: rejected
  FixedText<kMostText + 1> text;      ///< the value that the property now has, or the reason of the rejection

  /// Answers the request with this number. The program calls it.
  void answer(std::uint32_t request, bool done, std::string_view what) noexcept {
    ok = done ? 1 : 0;
    text.assign(what);
    number.store(request, std::memory_order_release);  // pairs with the load in answers()
  }
  /// True if this is the answer to `request`. The node calls it.
  [[nodiscard]] bool answers(const PropertyRequest& request) const noexcept {
    return number.load(std::memory_order_acquire) == request.number.load(std::memory_order_relaxed);
  }
};

}  // namespace takt::channel
