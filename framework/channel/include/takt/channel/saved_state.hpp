// What a module saves after each run(), in memory that outlives its process.
//
// A process that dies in the middle of saving must not spoil what it had saved before. So there are two
// places, written in turn, and a number that says which of them is whole. The number is stored last.
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

/// Bytes that one module may save.
inline constexpr std::uint32_t kMostSaved = 4096;

/// Of one module; all zero when nothing was saved. One writer at a time.
struct alignas(64) SavedState {
  struct Place {
    std::uint64_t number;   ///< how many times something was saved, this included
    std::int64_t saved_ns;  ///< monotonic time of the run() after which it was
    std::uint32_t version;  ///< as its author counts them
    std::uint32_t size;     ///< bytes, at most kMostSaved
    alignas(8) std::array<std::byte, kMostSaved> bytes;
  };
  std::atomic<std::uint64_t> whole;  ///< the newest number whose place is whole; 0: none. SYNC: saved
  std::array<Place, 2> places;

  /// Real-time. `size` is at most kMostSaved.
  void save(const void* from, std::uint32_t size, std::uint32_t version, std::int64_t now_ns) noexcept {
    const std::uint64_t number = whole.load(std::memory_order_relaxed) + 1;
    Place& place = places[number % 2];
    put(place.number, number);
    put(place.saved_ns, now_ns);
    put(place.version, version);
    put(place.size, size);
    for (std::uint32_t at = 0; at < size; at += kWord) {
      std::uint64_t word = 0;
      std::memcpy(&word, static_cast<const std::byte*>(from) + at, std::min(kWord, size - at));
      put(word_of(place, at), word);
    }
    whole.store(number, std::memory_order_release);  // SYNC: saved
  }
  /// What was saved last, while nobody saves; null when that is nothing, or not in order.
  [[nodiscard]] const Place* saved() const noexcept {
    const std::uint64_t number = whole.load(std::memory_order_acquire);  // SYNC: saved
    const Place& place = places[number % 2];
    return number == 0 || place.number != number || place.size > kMostSaved ? nullptr : &place;
  }
  /// The same, a copy, while somebody may be saving; none also when he was faster, twice in a row.
  [[nodiscard]] std::optional<Place> copy() noexcept {
    for (int attempt = 0; attempt < 3; ++attempt) {
      const std::uint64_t number = whole.load(std::memory_order_acquire);  // SYNC: saved
      if (number == 0) return std::nullopt;
      Place& place = places[number % 2];
      std::optional<Place> copied{std::in_place};
      copied->number = get(place.number);
      copied->saved_ns = get(place.saved_ns);
      copied->version = get(place.version);
      copied->size = get(place.size);
      if (copied->size > kMostSaved) return std::nullopt;
      for (std::uint32_t at = 0; at < copied->size; at += kWord)
        word_of(*copied, at) = get(word_of(place, at));
      // The next save goes to the other place; the one after it comes back to this one, and may have begun as
      // soon as the next is whole.
      if (whole.load(std::memory_order_relaxed) == number)
        return copied->number == number ? copied : std::nullopt;
    }
    return std::nullopt;
  }
  /// Nothing is saved. While nobody saves.
  void clear() noexcept { whole.store(0, std::memory_order_release); }

 private:
  static constexpr std::uint32_t kWord = sizeof(std::uint64_t);
  // Somebody may be saving while somebody copies, who then finds that out and begins again.
  template <class T>
  static void put(T& to, T value) noexcept {
    std::atomic_ref{to}.store(value, std::memory_order_relaxed);
  }
  template <class T>
  static T get(T& from) noexcept {
    return std::atomic_ref{from}.load(std::memory_order_acquire);  // before `whole` is looked at again
  }
  static std::uint64_t& word_of(Place& place, std::uint32_t at) noexcept {
    return *reinterpret_cast<std::uint64_t*>(place.bytes.data() + at);
  }
};

}  // namespace takt::channel
