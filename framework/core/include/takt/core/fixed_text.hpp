// Text of bounded length without the heap, for shared memory and for real-time threads.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace takt {

/// Holds at most N - 1 bytes and is always terminated; what does not fit is cut off. Trivially copyable.
template <std::size_t N>
class FixedText {
 public:
  FixedText() = default;
  explicit FixedText(std::string_view text) noexcept { assign(text); }

  void assign(std::string_view text) noexcept {
    const std::size_t length = text.size() < N ? text.size() : N - 1;
    std::memcpy(bytes_.data(), text.data(), length);
    bytes_[length] = '\0';
  }

  void append(std::string_view text) noexcept {
    const std::size_t used = view().size();
    const std::size_t length = text.size() < N - used ? text.size() : N - used - 1;
    std::memcpy(bytes_.data() + used, text.data(), length);
    bytes_[used + length] = '\0';
  }
  void append(std::int64_t number) noexcept {
    std::array<char, 24> digits{};
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
    append(std::string_view{digits.data(), static_cast<std::size_t>(end - digits.data())});
  }

  [[nodiscard]] std::string_view view() const noexcept {
    return {bytes_.data(), ::strnlen(bytes_.data(), N)};
  }
  [[nodiscard]] const char* c_str() const noexcept { return bytes_.data(); }
  [[nodiscard]] bool empty() const noexcept { return bytes_[0] == '\0'; }

 private:
  std::array<char, N> bytes_{};
};

}  // namespace takt
