// Text of limited length that needs no heap memory, for shared memory and for real-time threads.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace takt {

/// Holds a text of at most N - 1 bytes, which is always zero-terminated. Longer text is cut off. Trivially
/// copyable. Real-time threads may call all functions.
template <std::size_t N>
class FixedText {
 public:
  /// Creates an empty text.
  FixedText() = default;
  /// Copies `text`, and cuts it off after N - 1 bytes.
  explicit FixedText(std::string_view text) noexcept { assign(text); }

  /// Replaces the content by `text`, and cuts it off after N - 1 bytes.
  void assign(std::string_view text) noexcept {
    const std::size_t length = text.size() < N ? text.size() : N - 1;
    std::memcpy(bytes_.data(), text.data(), length);
    bytes_[length] = '\0';
  }

  /// Appends `text`, and cuts off the result after N - 1 bytes.
  void append(std::string_view text) noexcept {
    const std::size_t used = view().size();
    const std::size_t length = text.size() < N - used ? text.size() : N - used - 1;
    std::memcpy(bytes_.data() + used, text.data(), length);
    bytes_[used + length] = '\0';
  }
  /// Appends a number in decimal, and cuts off the result after N - 1 bytes.
  void append(std::int64_t number) noexcept {
    std::array<char, 24> digits{};
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
    append(std::string_view{digits.data(), static_cast<std::size_t>(end - digits.data())});
  }

  /// Returns the text, which is valid until this object changes.
  [[nodiscard]] std::string_view view() const noexcept {
    return {bytes_.data(), ::strnlen(bytes_.data(), N)};
  }
  /// Returns the text with a zero byte after it. The result is valid until this object changes.
  [[nodiscard]] const char* c_str() const noexcept { return bytes_.data(); }
  /// Returns true if the text is empty.
  [[nodiscard]] bool empty() const noexcept { return bytes_[0] == '\0'; }

 private:
  std::array<char, N> bytes_{};
};

}  // namespace takt
