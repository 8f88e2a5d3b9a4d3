// Writes and reads samples of port types as bytes in the format of DDS: XCDR1 after an encapsulation header
// of 4 bytes.
//
// Real-time threads cannot use Fast CDR, because it throws an exception if there are too few bytes, and
// exceptions allocate memory and lock. In this code, the first invalid value makes the whole sample invalid,
// and the caller checks this only once, after the last value.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>

namespace takt {

static_assert(std::endian::native == std::endian::little,
              "this code requires a little-endian machine, because it copies values without conversion");

/// The size of the encapsulation header at the start of each sample: two bytes for the representation (CDR
/// and its byte order), and two bytes for options.
inline constexpr std::size_t kEncapsulation = 4;

/// Returns the number of bytes that a sample of `bytes` bytes takes on the network. RTPS sends whole words of
/// 4 bytes, so up to 3 bytes of padding follow the sample.
constexpr std::size_t padded_sample(std::size_t bytes) noexcept { return (bytes + 3) / 4 * 4; }

/// Returns the number of padding bytes before a value with this alignment. `position` counts from the end of
/// the encapsulation header.
constexpr std::size_t cdr_padding(std::size_t position, std::size_t alignment) noexcept {
  return (alignment - position % alignment) % alignment;
}

/// Writes a sample in little endian. For real-time threads.
class CdrWriter {
 public:
  CdrWriter(std::byte* to, std::size_t size) noexcept
      : body_(to + std::min(size, kEncapsulation)),
        size_(size < kEncapsulation ? 0 : size - kEncapsulation),
        ok_(size >= kEncapsulation) {
    if (!ok_) return;
    constexpr std::array<std::uint8_t, kEncapsulation> kLittleEndian{0, 1, 0, 0};
    std::memcpy(to, kLittleEndian.data(), kLittleEndian.size());
  }

  template <class T>
  void put(T value) noexcept {
    put_array(&value, 1);
  }
  template <class T>
  void put_array(const T* values, std::size_t n) noexcept {
    static_assert(std::is_arithmetic_v<T>);
    if (n == 0) return;  // no padding is written before an empty array
    if (std::byte* at = room(sizeof(T), n * sizeof(T))) std::memcpy(at, values, n * sizeof(T));
  }
  /// Writes an enumerator. Fails if `value` is not below `count`, the number of enumerators.
  void put_enumerator(std::uint32_t value, std::uint32_t count) noexcept {
    if (value >= count) return fail();
    put(value);
  }
  /// Writes the length of a sequence, which comes before the elements. Fails if the length exceeds `bound`.
  void put_length(std::size_t length, std::size_t bound) noexcept {
    if (length > bound) return fail();
    put(static_cast<std::uint32_t>(length));
  }
  /// Writes a text that ends at the first zero byte, or after `limit` bytes if these bytes contain no zero
  /// byte. Fails if the text is longer than `bound` bytes.
  void put_text(const char* text, std::size_t limit, std::size_t bound) noexcept {
    const std::size_t length = ::strnlen(text, limit);
    put_length(length + 1, bound + 1);
    if (std::byte* at = room(1, length + 1)) {
      std::memcpy(at, text, length);
      at[length] = std::byte{0};
    }
  }

  void fail() noexcept { ok_ = false; }
  /// Returns the size of the sample in bytes, including the encapsulation header; 0 if a value was invalid or
  /// the sample did not fit.
  [[nodiscard]] std::uint32_t size() const noexcept {
    return ok_ ? static_cast<std::uint32_t>(kEncapsulation + position_) : 0;
  }

 private:
  std::byte* room(std::size_t alignment, std::size_t bytes) noexcept {
    const std::size_t padding = cdr_padding(position_, alignment);
    if (!ok_ || size_ - position_ < padding || size_ - position_ - padding < bytes) {
      fail();
      return nullptr;
    }
    std::byte* at = body_ + position_;
    std::memset(at, 0, padding);
    position_ += padding + bytes;
    return at + padding;
  }

  std::byte* body_;  // the bytes after the encapsulation header; values are aligned relative to this address
  std::size_t size_;
  std::size_t position_ = 0;
  bool ok_;
};

/// Reads a sample in either byte order. Safe for any bytes: after the first error, all values that are read
/// are zero. For real-time threads.
class CdrReader {
 public:
  CdrReader(const std::byte* from, std::size_t size) noexcept
      : body_(from + std::min(size, kEncapsulation)),
        size_(size < kEncapsulation ? 0 : size - kEncapsulation) {
    // Other values of the first two bytes mean a representation that port types never use, such as a
    // parameter list or XCDR2.
    ok_ = size >= kEncapsulation && from[0] == std::byte{0} &&
          (from[1] == std::byte{0} || from[1] == std::byte{1});
    swap_ = ok_ && from[1] == std::byte{0};
  }

  template <class T>
  [[nodiscard]] T get() noexcept {
    T value{};
    get_array(&value, 1);
    return value;
  }
  template <class T>
  void get_array(T* values, std::size_t n) noexcept {
    static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    const std::byte* at = take_array(sizeof(T), n);
    if (at == nullptr) return;
    std::memcpy(values, at, n * sizeof(T));
    if constexpr (sizeof(T) > 1) {
      if (swap_) std::for_each(values, values + n, [](T& value) { value = swapped(value); });
    }
  }
  /// Reads a boolean. Fails if its byte is neither 0 nor 1.
  [[nodiscard]] bool get_boolean() noexcept {
    const auto value = get<std::uint8_t>();
    if (value > 1) fail();
    return value == 1;
  }
  /// Reads an enumerator. Fails if its value is not below `count`, the number of enumerators.
  [[nodiscard]] std::uint32_t get_enumerator(std::uint32_t count) noexcept {
    const auto value = get<std::uint32_t>();
    if (value < count) return value;
    fail();
    return 0;
  }
  /// Reads the length of a sequence, which comes before the elements. Fails if the length exceeds `bound` or
  /// the number of remaining bytes.
  [[nodiscard]] std::size_t get_length(std::size_t bound) noexcept {
    const std::size_t length = get<std::uint32_t>();
    // Each element takes at least one byte, so a length above the number of remaining bytes is invalid.
    if (length <= bound && length <= size_ - position_) return length;
    fail();
    return 0;
  }
  /// Reads a text of at most `bound` bytes. A zero byte follows the text in the sample, so the data of the
  /// returned view is zero-terminated.
  [[nodiscard]] std::string_view get_text(std::size_t bound) noexcept {
    const std::size_t length = get_length(bound + 1);
    const std::byte* at = take_array(1, length);
    if (at != nullptr && std::memchr(at, 0, length) == at + length - 1)
      return {reinterpret_cast<const char*>(at), length - 1};
    fail();
    return {""};
  }
  /// Reads a text and copies it into an array of at least bound + 1 bytes.
  void get_text(char* text, std::size_t bound) noexcept {
    const std::string_view view = get_text(bound);
    std::memcpy(text, view.data(), view.size() + 1);
  }
  /// Reads an array and returns its bytes, which are in the byte order of the sample. Returns null if `n` is
  /// 0, if fewer than `n` values remain in the sample, or after an error.
  [[nodiscard]] const std::byte* take_array(std::size_t element_size, std::size_t n) noexcept {
    if (n == 0 || !ok_) return nullptr;
    const std::size_t padding = cdr_padding(position_, element_size);
    const std::size_t left = size_ - position_;
    if (left < padding || (left - padding) / element_size < n) {
      fail();
      return nullptr;
    }
    const std::byte* at = body_ + position_ + padding;
    position_ += padding + n * element_size;
    return at;
  }

  void fail() noexcept { ok_ = false; }
  [[nodiscard]] bool ok() const noexcept { return ok_; }
  /// Returns true if the bytes were exactly one sample, with up to 3 bytes of padding at the end.
  [[nodiscard]] bool complete() const noexcept { return ok_ && size_ - position_ < 4; }

 private:
  template <class T>
  static T swapped(T value) noexcept {
    auto bytes = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
    std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<T>(bytes);
  }

  const std::byte* body_;
  std::size_t size_;
  std::size_t position_ = 0;
  bool ok_;
  bool swap_;
};

}  // namespace takt
