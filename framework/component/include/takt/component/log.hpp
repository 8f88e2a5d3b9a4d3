// Log lines in C++. Every hook of a component, including run(), and a process module can write them:
//
//   log().info("lost the part at {:.2f} m", x);
//
// The call copies the format and the arguments into a ring in shared memory; the node formats the text. So a
// real-time thread may log. `takt log` and the web page show the lines.
#pragma once

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include <takt/channel/log_ring.hpp>
#include <takt/core/log_level.hpp>

namespace takt {

namespace detail {

/// The ring to which the calling thread adds log records, and the run to which the records belong.
struct LogTarget {
  channel::LogRing* ring = nullptr;  // null: the thread runs no hook, so its log lines are lost
  std::uint64_t cycle = 0;
  std::int64_t time_ns = 0;
};
LogTarget log_target() noexcept;

void write_log(LogLevel level, std::string_view format, const channel::LogArgument* arguments,
               std::size_t count) noexcept;

/// The reason why a log call does not compile.
template <std::size_t N>
struct Reason {
  consteval Reason(const char (&sentence)[N]) {  // NOLINT: implicit
    std::copy(sentence, sentence + N, text);
  }
  char text[N]{};
};

// This function is not constexpr. If the check of a format calls it during compilation, the compiler reports
// an error with the reason.
template <Reason reason>
void reject_log_call() {}

template <class T>
inline constexpr bool kIsLiteral = false;

/// Returns the number of replacement fields, {} or {:SPEC}, in a format. {{ and }} stand for single braces.
consteval std::size_t places_in(std::string_view format) {
  std::size_t places = 0;
  for (std::size_t i = 0; i < format.size(); ++i) {
    if (format[i] != '{' && format[i] != '}') continue;
    if (i + 1 < format.size() && format[i + 1] == format[i]) {
      ++i;
      continue;
    }
    const std::size_t end = format.find('}', i);
    const bool empty = end == i + 1;
    if (format[i] == '}' || end == std::string_view::npos || (!empty && format[i + 1] != ':') ||
        format.substr(i + 1, end - i - 1).find('{') != std::string_view::npos)
      reject_log_call<"use only {} and {:SPEC} in a log format, and {{ or }} for a brace">();
    ++places;
    i = end;
  }
  return places;
}

/// A format with exactly `Arguments` replacement fields; any other format does not compile.
template <std::size_t Arguments>
struct LogFormat {
  template <std::size_t N>
  consteval LogFormat(const char (&literal)[N]) : text(literal, N - 1) {  // NOLINT: implicit
    static_assert(N - 1 <= 150, "a log format has at most 150 characters");
    if (places_in(text) > Arguments) reject_log_call<"this log call has more {} than arguments">();
    if (places_in(text) < Arguments) reject_log_call<"this log call has more arguments than {}; % does not stand for an argument">();
  }
  template <class T>
  LogFormat(T&&) {  // NOLINT: implicit; also takes a format that is not a literal, to report it
    static_assert(
        kIsLiteral<T>,
        "the format of a log call must be a literal; to log a text, write log().info(\"{}\", text)");
  }
  std::string_view text;
};

template <class T>
channel::LogArgument log_argument(const T& value) noexcept {
  using Kind = channel::LogArgumentKind;
  if constexpr (std::is_same_v<T, bool>) {
    return {Kind::boolean, value ? 1U : 0U};
  } else if constexpr (std::is_same_v<T, char>) {
    return {Kind::character, static_cast<std::uint8_t>(value)};
  } else if constexpr (std::is_enum_v<T>) {
    return log_argument(static_cast<std::underlying_type_t<T>>(value));
  } else if constexpr (std::signed_integral<T>) {
    return {Kind::integer, static_cast<std::uint64_t>(std::int64_t{value})};
  } else if constexpr (std::unsigned_integral<T>) {
    return {Kind::natural, value};
  } else if constexpr (std::floating_point<T>) {
    return {Kind::real, std::bit_cast<std::uint64_t>(static_cast<double>(value))};
  } else if constexpr (requires { value.value_text(); }) {  // Property
    return log_argument(value.value());
  } else if constexpr (requires { value.view(); }) {  // BoundedString
    return {Kind::text, value.view().size(), value.view().data()};
  } else {
    static_assert(std::is_convertible_v<const T&, std::string_view>,
                  "an argument of a log call is a number, a bool, a char, an enumerator, a text or a property");
    const std::string_view text{value};
    return {Kind::text, text.size(), text.data()};
  }
}

}  // namespace detail

/// The log of the module whose hook the calling thread runs; see log(). A format has replacement fields {}
/// with the format specifications of std::format, but width and precision must be below 100. The compiler
/// checks the number of arguments. Arguments are numbers, bools, chars, enumerators, texts and properties, at
/// most 8.
/// Takt keeps at most 216 bytes of the format and the text arguments together. If the ring is full, the line
/// is dropped and counted. A real-time thread may call all functions.
class Log {
 public:
  /// Logs that something failed.
  template <class... T>
  void error(std::type_identity_t<detail::LogFormat<sizeof...(T)>> format,
             const T&... arguments) const noexcept {
    write(LogLevel::error, format.text, arguments...);
  }
  /// Logs that something is not as it should be.
  template <class... T>
  void warning(std::type_identity_t<detail::LogFormat<sizeof...(T)>> format,
               const T&... arguments) const noexcept {
    write(LogLevel::warning, format.text, arguments...);
  }
  /// Logs an event of normal operation.
  template <class... T>
  void info(std::type_identity_t<detail::LogFormat<sizeof...(T)>> format,
            const T&... arguments) const noexcept {
    write(LogLevel::info, format.text, arguments...);
  }
  /// Logs details for the author. By default, a module does not log them, because its log level is `info`.
  template <class... T>
  void debug(std::type_identity_t<detail::LogFormat<sizeof...(T)>> format,
             const T&... arguments) const noexcept {
    write(LogLevel::debug, format.text, arguments...);
  }

 private:
  template <class... T>
  static void write(LogLevel level, std::string_view format, const T&... arguments) noexcept {
    static_assert(sizeof...(T) <= channel::LogRecord::kArguments, "a log call has at most 8 arguments");
    if constexpr (sizeof...(T) == 0) {
      detail::write_log(level, format, nullptr, 0);
    } else {
      const channel::LogArgument all[] = {detail::log_argument(arguments)...};
      detail::write_log(level, format, all, sizeof...(T));
    }
  }
};

/// The log of the calling process module, or of the module whose hook the calling thread runs. A line carries
/// the number of the module's release (Cycle::number) and the time at which its run began. Lines that other
/// threads of a thread module log are lost. A real-time thread may call it.
inline Log log() noexcept { return {}; }

/// Reports whether the calling process module, or the module whose hook the calling thread runs, is in a safe
/// stop. In a safe stop, a module works as intended, and keeps its machine stopped for safety. `takt status`,
/// `takt watch`, `takt log` and the web page show the safe stop while the module is in EXECUTING. A reset of
/// the module ends the safe stop. A real-time thread may call it.
inline void safe_stop(bool stopped) noexcept {
  if (channel::LogRing* const ring = detail::log_target().ring)
    ring->safe_stop.store(stopped ? 1 : 0, std::memory_order_relaxed);
}

}  // namespace takt
