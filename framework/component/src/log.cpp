// takt_log() and the C++ log calls, for components and process modules.
#include <cstdarg>
#include <cstring>

#include <takt/log.h>
#include <takt/component/log.hpp>

namespace takt::detail {

void write_log(LogLevel level, std::string_view format, const channel::LogArgument* arguments,
               std::size_t count) noexcept {
  const LogTarget target = log_target();
  if (target.ring == nullptr || static_cast<std::uint32_t>(level) > target.ring->threshold()) return;
  target.ring->add({.level = static_cast<std::uint8_t>(level),
                    .percent = false,
                    .time_ns = target.time_ns,
                    .cycle = target.cycle,
                    .format = format.data(),
                    .format_size = format.size()},
                   arguments, count);
}

namespace {

using Kind = channel::LogArgumentKind;

/// Reads the arguments of a printf() format from `list`, and returns their number. Stops at the first
/// conversion that is not supported, because the type of its argument is not known.
std::size_t take_arguments(const char* format, std::va_list& list,
                           channel::LogArgument (&arguments)[channel::LogRecord::kArguments]) noexcept {
  std::size_t count = 0;
  for (const char* at = std::strchr(format, '%'); at != nullptr; at = std::strchr(at, '%')) {
    ++at;
    at += std::strspn(at, "-+ #0");
    at += std::strspn(at, "0123456789.");
    int longs = 0;
    bool wide = false;
    for (; *at != '\0' && std::strchr("hlzjt", *at) != nullptr; ++at) {
      if (*at == 'l') ++longs;
      wide = wide || std::strchr("zjt", *at) != nullptr;
    }
    if (*at == '%') {
      ++at;
      continue;
    }
    if (*at == '\0' || std::strchr("diuxXocfFeEgGs", *at) == nullptr ||
        count == channel::LogRecord::kArguments)
      break;
    channel::LogArgument& argument = arguments[count++];
    const bool is_long = longs > 0 || wide;  // long, long long, size_t, intmax_t and ptrdiff_t have 64 bits
    switch (*at++) {
      case 'd':
      case 'i':
        argument = {Kind::integer,
                    static_cast<std::uint64_t>(is_long ? va_arg(list, std::int64_t) : va_arg(list, int))};
        break;
      case 'u':
      case 'x':
      case 'X':
      case 'o':
        argument = {Kind::natural, is_long ? va_arg(list, std::uint64_t) : va_arg(list, unsigned)};
        break;
      case 'c':
        argument = {Kind::character, static_cast<std::uint8_t>(va_arg(list, int))};
        break;
      case 's': {
        const char* text = va_arg(list, const char*);
        if (text == nullptr) text = "(null)";
        argument = {Kind::text, ::strnlen(text, channel::LogRecord::kText), text};
        break;
      }
      default:
        argument = {Kind::real, std::bit_cast<std::uint64_t>(va_arg(list, double))};
    }
  }
  return count;
}

}  // namespace
}  // namespace takt::detail

extern "C" void takt_safe_stop(int stopped) { takt::safe_stop(stopped != 0); }

extern "C" void takt_log(int level, const char* format, ...) {
  using namespace takt;
  const detail::LogTarget target = detail::log_target();
  if (target.ring == nullptr || level < TAKT_LOG_ERROR ||
      static_cast<std::uint32_t>(level) > target.ring->threshold() || format == nullptr) {
    return;
  }
  channel::LogArgument arguments[channel::LogRecord::kArguments];
  std::va_list list;
  va_start(list, format);
  const std::size_t count = detail::take_arguments(format, list, arguments);
  va_end(list);
  target.ring->add({.level = static_cast<std::uint8_t>(level),
                    .percent = true,
                    .time_ns = target.time_ns,
                    .cycle = target.cycle,
                    .format = format,
                    .format_size = ::strnlen(format, channel::LogRecord::kText)},
                   arguments, count);
}
