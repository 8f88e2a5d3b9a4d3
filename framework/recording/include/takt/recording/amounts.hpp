// Formats sizes and dates for people.
#pragma once

#include <cstdint>
#include <ctime>
#include <string>

#include <fmt/chrono.h>
#include <fmt/format.h>

namespace takt::recording {

/// Formats a number of bytes, such as "812 kB" or "1.5 MB".
inline std::string bytes_text(std::uint64_t bytes) {
  const double number = static_cast<double>(bytes);
  if (bytes < 1'000'000) return fmt::format("{:.0f} kB", number / 1e3);
  if (bytes < 1'000'000'000) return fmt::format("{:.1f} MB", number / 1e6);
  return fmt::format("{:.2f} GB", number / 1e9);
}

/// Formats a time since 1970, such as "2026-11-21 22:36:37.123 UTC".
inline std::string date_text(std::int64_t time_ns) {
  const std::int64_t day = 1'000'000'000;
  const std::int64_t second = time_ns / day - (time_ns % day < 0 ? 1 : 0);
  const std::int64_t ms = (time_ns - second * day) / 1'000'000;
  return fmt::format("{:%Y-%m-%d %H:%M:%S}.{:03} UTC", fmt::gmtime(static_cast<std::time_t>(second)), ms);
}

}  // namespace takt::recording
