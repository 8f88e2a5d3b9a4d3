// The state that a module saves after each run(), in memory that outlives the module's process.
//
// A process that dies while it saves must not damage the state that it saved before. So there are two copies,
// written in turn, and a number that states which copy is complete. The number is written last.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>

namespace takt::channel {

/// The maximum number of bytes that one module may save.
inline constexpr std::uint32_t kMostSaved = 4096;

/// The saved state of one module. All bytes are zero if nothing was saved. There is one writer at a time.
struct alignas(64) SavedState {
  struct Copy {
    std::uint64_t number;   ///< number of times that the module has saved, including this time
    std::int64_t saved_ns;  ///< monotonic time of the run() after which the module saved
    std::uint32_t version;  ///< version of the data's layout, which the module's author chooses
    std::uint32_t size;     ///< number of saved bytes, at most kMostSaved
    alignas(8) std::array<std::byte, kMostSaved> bytes;
  };
  std::atomic<std::uint64_t> whole;  ///< `number` of the newest complete copy, stored after it; 0: none
  std::array<Copy, 2> copies;

  /// Saves `size` bytes, at most kMostSaved. A real-time thread may call it.
  void save(const void* from, std::uint32_t size, std::uint32_t version, std::int64_t now_ns) noexcept {
    const std::uint64_t number = whole.load(std::memory_order_relaxed) + 1;
    Copy& copy = copies[number % 2];
    put(copy.number, number);
    put(copy.saved_ns, now_ns);
    put(copy.version, version);
    put(copy.size, size);
    for (std::uint32_t at = 0; at < size; at += kWord) {
      std::uint64_t word = 0;
      std::memcpy(&word, static_cast<const std::byte*>(from) + at, std::min(kWord, size - at));
      put(word_of(copy, at), word);
    }
    whole.store(number, std::memory_order_release);  // after the copy is complete
  }
  /// Returns the state that was saved last, or null if nothing was saved or the state is damaged. Call it
  /// only while the module is not saving.
  [[nodiscard]] const Copy* saved() const noexcept {
    const std::uint64_t number = whole.load(std::memory_order_acquire);  // pairs with the store in save()
    const Copy& copy = copies[number % 2];
    return number == 0 || copy.number != number || copy.size > kMostSaved ? nullptr : &copy;
  }
  /// Returns a copy of the state that was saved last. The copy is correct even if the module saves a new
  /// state during the call. Returns nothing if no state was saved, if the saved state is damaged, or if the
  /// module saved during each of three attempts.
  [[nodiscard]] std::optional<Copy> copy() noexcept {
    for (int attempt = 0; attempt < 3; ++attempt) {
      const std::uint64_t number = whole.load(std::memory_order_acquire);  // pairs with the store in save()
      if (number == 0) return std::nullopt;
      Copy& copy = copies[number % 2];
      std::optional<Copy> copied{std::in_place};
      copied->number = get(copy.number);
      copied->saved_ns = get(copy.saved_ns);
      copied->version = get(copy.version);
      copied->size = get(copy.size);
      if (copied->size > kMostSaved) return std::nullopt;
      for (std::uint32_t at = 0; at < copied->size; at += kWord)
        word_of(*copied, at) = get(word_of(copy, at));
      // The next save writes the other copy. The save after it overwrites this one, and can begin as soon as
      // `whole` shows the next save.
      if (whole.load(std::memory_order_relaxed) == number)
        return copied->number == number ? copied : std::nullopt;
    }
    return std::nullopt;
  }
  /// Discards the saved state. Call it only while the module is not saving.
  void clear() noexcept { whole.store(0, std::memory_order_release); }

 private:
  static constexpr std::uint32_t kWord = sizeof(std::uint64_t);
  // These accesses are atomic, because the module may save while copy() reads. Each store is a release store,
  // so a reader that sees a part of a save also sees in `whole` that the save before it is complete. copy()
  // then begins again.
  template <class T>
  static void put(T& to, T value) noexcept {
    std::atomic_ref{to}.store(value, std::memory_order_release);
  }
  template <class T>
  static T get(T& from) noexcept {
    return std::atomic_ref{from}.load(
        std::memory_order_acquire);  // ordered before the second load of `whole`
  }
  static std::uint64_t& word_of(Copy& copy, std::uint32_t at) noexcept {
    return *reinterpret_cast<std::uint64_t*>(copy.bytes.data() + at);
  }
};

}  // namespace takt::channel
