// Validators for numbers on the command line. The validator CLI::Range of CLI11 is not strict enough: it
// accepts nan, and reads a negative number as a number near 2^64.
#pragma once

#include <cctype>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace takt::tool {

/// Accepts a number from `from` to `to`. `what` describes the number in the message.
inline CLI::Validator within(double from, double to, const char* what = "a number") {
  return CLI::Validator{[from, to, what](const std::string& text) -> std::string {
                          char* end = nullptr;
                          const double value = std::strtod(text.c_str(), &end);
                          const bool number = end != text.c_str() && *end == '\0';
                          if (number && value >= from && value <= to) return "";
                          return fmt::format("'{}' is not {} from {} to {}", text, what, from, to);
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

/// Accepts the name of a file for an SVG drawing: any name that does not end like another kind of picture.
inline CLI::Validator svg_file() {
  return CLI::Validator{[](const std::string& file) -> std::string {
                          const std::size_t dot = file.rfind('.');
                          const std::string end = dot == std::string::npos ? "" : file.substr(dot);
                          for (const char* other : {".png", ".jpg", ".jpeg", ".gif", ".pdf", ".webp"}) {
                            if (end == other)
                              return "'" + file + "' ends in " + end + ", but the drawing is an SVG file; write " +
                                  file.substr(0, dot) + ".svg";
                          }
                          return "";
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
