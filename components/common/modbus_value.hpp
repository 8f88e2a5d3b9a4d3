// Converts between a number and one or two registers of a Modbus device. Real-time threads may use everything
// here except range_text().
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace modbus {

enum class Type { uint16, int16, uint32, int32, float32 };

struct Encoding {
  Type type = Type::uint16;
  double scale = 1;  ///< value = register content * scale + offset; not 0
  double offset = 0;
  bool low_first = false;      ///< true: the first of two registers holds the low word; usually the high word
  bool bytes_swapped = false;  ///< true: each of two registers holds its low byte first
};

/// Returns the number of registers that hold a value of this type.
constexpr unsigned words(Type type) noexcept { return type == Type::uint16 || type == Type::int16 ? 1 : 2; }

/// Returns the word as a register of this encoding holds it, and the other way round.
constexpr std::uint16_t in_register(const Encoding& encoding, std::uint32_t word) noexcept {
  return static_cast<std::uint16_t>(encoding.bytes_swapped ? word << 8 | (word >> 8 & 0xFF) : word);
}

inline std::optional<Type> type_of(std::string_view text) noexcept {
  if (text == "uint16") return Type::uint16;
  if (text == "int16") return Type::int16;
  if (text == "uint32") return Type::uint32;
  if (text == "int32") return Type::int32;
  if (text == "float32") return Type::float32;
  return std::nullopt;
}

struct Range {
  double min;
  double max;
};
/// Returns the range of the numbers that registers of this type can hold.
constexpr Range raw_range(Type type) noexcept {
  switch (type) {
    case Type::uint16:
      return {0, 65535};
    case Type::int16:
      return {-32768, 32767};
    case Type::uint32:
      return {0, 4294967295.0};
    case Type::int32:
      return {-2147483648.0, 2147483647};
    case Type::float32:
      return {std::numeric_limits<float>::lowest(), std::numeric_limits<float>::max()};
  }
  return {0, 0};
}

inline bool fits(const Encoding& encoding, double value) noexcept {
  const Range range = raw_range(encoding.type);
  const double raw = (value - encoding.offset) / encoding.scale;
  return raw > range.min - 0.5 && raw < range.max + 0.5;
}

inline std::string range_text(const Encoding& encoding) {
  const auto text = [](double x) {
    std::array<char, 32> buffer{};
    return std::string{buffer.data(),
                       static_cast<std::size_t>(std::snprintf(buffer.data(), buffer.size(), "%g", x))};
  };
  const Range raw = raw_range(encoding.type);
  const double a = raw.min * encoding.scale + encoding.offset;
  const double b = raw.max * encoding.scale + encoding.offset;
  return text(std::min(a, b)) + " to " + text(std::max(a, b));
}

/// Writes the value, rounded and clamped to the range of its type, into words(type) registers. If the value
/// is NaN, returns false and writes nothing.
inline bool encode(const Encoding& encoding, double value, std::uint16_t* to) noexcept {
  const Range range = raw_range(encoding.type);
  const double raw = (value - encoding.offset) / encoding.scale;
  if (std::isnan(raw)) return false;
  const double held = std::clamp(raw, range.min, range.max);
  std::uint32_t bits = 0;
  if (encoding.type == Type::float32)
    bits = std::bit_cast<std::uint32_t>(static_cast<float>(held));
  else
    bits = static_cast<std::uint32_t>(std::llround(held));  // modulo 2^32, which gives two's complement
  if (words(encoding.type) == 1) {
    to[0] = static_cast<std::uint16_t>(bits);
    return true;
  }
  to[encoding.low_first ? 1 : 0] = in_register(encoding, bits >> 16);
  to[encoding.low_first ? 0 : 1] = in_register(encoding, bits);
  return true;
}

/// Converts registers to a value. The value is not finite if the registers hold a float32 that is not finite.
inline double decode(const Encoding& encoding, const std::uint16_t* from) noexcept {
  double raw = 0;
  if (words(encoding.type) == 1) {
    raw = encoding.type == Type::int16 ? static_cast<double>(static_cast<std::int16_t>(from[0])) : from[0];
  } else {
    const std::uint32_t high = in_register(encoding, from[encoding.low_first ? 1 : 0]);
    const std::uint32_t bits = high << 16 | in_register(encoding, from[encoding.low_first ? 0 : 1]);
    raw = encoding.type == Type::float32 ? static_cast<double>(std::bit_cast<float>(bits))
          : encoding.type == Type::int32 ? static_cast<double>(static_cast<std::int32_t>(bits))
                                         : bits;
  }
  return raw * encoding.scale + encoding.offset;
}

}  // namespace modbus
