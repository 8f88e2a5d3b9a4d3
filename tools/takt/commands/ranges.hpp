// Validators for numbers on the command line. CLI::Range is not strict enough: it accepts nan, and reads a
// negative number as a number near 2^64.
#pragma once

#include <cctype>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace takt::tool {

/// Accepts a number from `from` to `to`.
inline CLI::Validator within(double from, double to) {
  return CLI::Validator{[from, to](const std::string& text) -> std::string {
                          char* end = nullptr;
                          const double value = std::strtod(text.c_str(), &end);
                          const bool number = end != text.c_str() && *end == '\0';
                          if (number && value >= from && value <= to) return "";
                          return fmt::format("'{}' is not a number from {} to {}", text, from, to);
                        },
                        ""};
}

/// Accepts a number of seconds above 0. CLI::PositiveNumber is not suitable: it accepts inf, and prints its
/// range with 308 digits.
inline CLI::Validator positive_seconds() {
  return CLI::Validator{[](const std::string& text) -> std::string {
                          constexpr double kLongest = 1e9;
                          char* end = nullptr;
                          const double value = std::strtod(text.c_str(), &end);
                          const bool number = end != text.c_str() && *end == '\0';
                          if (number && value > 0 && value <= kLongest) return "";
                          return "'" + text + "' is not a number of seconds above 0 and at most 1e9";
                        },
                        ""};
}

/// Accepts a whole number that fits into 64 bits.
inline CLI::Validator whole_number() {
  return CLI::Validator{[](const std::string& text) -> std::string {
                          bool digits = !text.empty() && text.size() <= 20;
                          for (const char c : text)
                            digits &= std::isdigit(static_cast<unsigned char>(c)) != 0;
                          errno = 0;
                          if (digits) static_cast<void>(std::strtoull(text.c_str(), nullptr, 10));
                          if (digits && errno == 0) return "";
                          return "'" + text + "' is not a whole number from 0 to 18446744073709551615";
                        },
                        ""};
}

}  // namespace takt::tool
