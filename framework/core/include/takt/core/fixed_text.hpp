// Text of bounded length without the heap, for shared memory and for real-time threads.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace takt {

/// Holds at most N - 1 bytes and is always zero-terminated. Longer text is cut off. Trivially copyable. All
/// functions are real-time.
template <std::size_t N>
class FixedText {
 public:
  /// An empty text.
  FixedText() = default;
  /// A copy of `text`, cut off if it is too long.
  explicit FixedText(std::string_view text) noexcept { assign(text); }

  /// Replaces the text. Cuts off what does not fit.
  void assign(std::string_view text) noexcept {
    const std::size_t length = text.size() < N ? text.size() : N - 1;
    std::memcpy(bytes_.data(), text.data(), length);
    bytes_[length] = '\0';
  }

  /// Appends a text. Cuts off what does not fit.
  void append(std::string_view text) noexcept {
    const std::size_t used = view().size();
    const std::size_t length = text.size() < N - used ? text.size() : N - used - 1;
    std::memcpy(bytes_.data() + used, text.data(), length);
    bytes_[used + length] = '\0';
  }
  /// Appends a number in decimal. Cuts off what does not fit.
  void append(std::int64_t number) noexcept {
    std::array<char, 24> digits{};
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
    append(std::string_view{digits.data(), static_cast<std::size_t>(end - digits.data())});
  }

  /// The text. Valid until the object changes.
  [[nodiscard]] std::string_view view() const noexcept {
    return {bytes_.data(), ::strnlen(bytes_.data(), N)};
  }
  /// The text, zero-terminated. Valid until the object changes.
  [[nodiscard]] const char* c_str() const noexcept { return bytes_.data(); }
  /// Whether the text is empty.
  [[nodiscard]] bool empty() const noexcept { return bytes_[0] == '\0'; }

 private:
  std::array<char, N> bytes_{};
};

}  // namespace takt
