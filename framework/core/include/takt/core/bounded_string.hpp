// BoundedString<N>: the C++ type of an IDL string<N> in a port type. It stores its characters inline, so a
// real-time thread can copy it without allocating memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>

namespace takt {

/// Holds a text of at most N bytes and a zero byte after it. Longer text is cut off. Converts from and to C
/// strings and std::string. A real-time thread may call every function except to_string().
template <std::size_t N>
class BoundedString {
 public:
  /// The maximum length of the text in bytes.
  static constexpr std::size_t max_size = N;

  /// Creates an empty text.
  BoundedString() noexcept = default;
  // NOLINTBEGIN(google-explicit-constructor): a text is assigned and passed like a std::string
  /// Copies a C string. A null pointer counts as the empty text.
  BoundedString(const char* text) noexcept { *this = text; }
  /// Copies a text.
  BoundedString(const std::string& text) noexcept { assign(std::string_view{text}); }
  /// Copies a text.
  BoundedString(std::string_view text) noexcept { assign(text); }
  /// Returns the text as a C string.
  operator const char*() const noexcept { return text_; }
  // NOLINTEND(google-explicit-constructor)
  /// Copies the first `size` bytes of `text`.
  BoundedString(const char* text, std::size_t size) noexcept { assign(text, size); }

  /// Copies a C string. A null pointer counts as the empty text.
  BoundedString& operator=(const char* text) noexcept {
    return assign(text == nullptr ? std::string_view{} : std::string_view{text});
  }
  /// Copies a text.
  BoundedString& operator=(const std::string& text) noexcept { return assign(std::string_view{text}); }
  /// Copies a text.
  BoundedString& operator=(std::string_view text) noexcept { return assign(text); }
  /// Copies a BoundedString with a different bound.
  template <std::size_t M>
  BoundedString& operator=(const BoundedString<M>& text) noexcept {
    return assign(text.view());
  }
  /// Copies the first `size` bytes of `text`.
  BoundedString& assign(const char* text, std::size_t size) noexcept { return assign({text, size}); }

  /// Returns the text, with a zero byte after it.
  [[nodiscard]] const char* c_str() const noexcept { return text_; }
  /// Returns the text without the zero byte. The result is valid until the next change of this object.
  [[nodiscard]] std::string_view view() const noexcept { return {text_, size_}; }
  /// Returns a copy of the text. Allocates memory.
  [[nodiscard]] std::string to_string() const { return std::string{view()}; }
  /// Returns the number of bytes before the zero byte.
  [[nodiscard]] std::size_t size() const noexcept { return size_; }

  /// True if the texts are equal.
  bool operator==(const char* text) const noexcept { return view() == text; }
  /// True if the texts are equal.
  bool operator==(const std::string& text) const noexcept { return view() == text; }
  /// True if the texts are equal.
  bool operator==(std::string_view text) const noexcept { return view() == text; }
  /// True if the texts are equal.
  template <std::size_t M>
  bool operator==(const BoundedString<M>& text) const noexcept {
    return view() == text.view();
  }

 private:
  BoundedString& assign(std::string_view text) noexcept {
    size_ = std::min(text.size(), N);
    std::copy_n(text.data(), size_, text_);
    text_[size_] = '\0';
    return *this;
  }

  char text_[N + 1]{};
  std::size_t size_ = 0;
};

}  // namespace takt
