#include <takt/host/log_reader.hpp>

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include <fmt/args.h>
#include <fmt/format.h>

#include <takt/core/words.hpp>

namespace takt::host {

namespace {

using channel::LogArgumentKind;
using channel::LogRecord;

constexpr std::size_t kMostText = 400;
constexpr std::size_t kMostSpecification = 12;

/// The content of a record, copied so that the record's writer can no longer change it.
struct Copy {
  std::string format;
  bool percent = false;
  std::size_t count = 0;  // number of arguments
  fmt::dynamic_format_arg_store<fmt::format_context> arguments;
};

std::string text_at(const std::array<char, LogRecord::kText>& text, std::uint64_t begin, std::uint64_t size) {
  if (begin > text.size()) return {};
  return {text.data() + begin, static_cast<std::size_t>(std::min<std::uint64_t>(size, text.size() - begin))};
}

void add(Copy& copy, LogArgumentKind kind, std::uint64_t value,
         const std::array<char, LogRecord::kText>& text) {
  switch (kind) {
    case LogArgumentKind::boolean:
      return copy.arguments.push_back(value != 0);
    case LogArgumentKind::character:
      return copy.arguments.push_back(static_cast<char>(value));
    case LogArgumentKind::integer:
      return copy.arguments.push_back(static_cast<std::int64_t>(value));
    case LogArgumentKind::natural:
      return copy.arguments.push_back(value);
    case LogArgumentKind::real:
      return copy.arguments.push_back(std::bit_cast<double>(value));
    case LogArgumentKind::text:
      return copy.arguments.push_back(text_at(text, value >> 32, value & 0xffff'ffff));
    case LogArgumentKind::none:
      break;
  }
  copy.arguments.push_back("?");
}

/// True if fmt needs little memory for this specification: the specification is short, contains no
/// replacement field, and no number in it has more than two digits.
bool is_modest(std::string_view specification) {
  std::size_t digits = 0;
  for (const char c : specification) {
    digits = c >= '0' && c <= '9' ? digits + 1 : 0;
    if (digits > 2 || c == '{') return false;
  }
  return specification.size() <= kMostSpecification;
}

/// True if every replacement field of this format is modest, so that fmt needs little memory for the text.
bool is_modest_format(std::string_view format) {
  for (std::size_t i = 0; i < format.size(); ++i) {
    if (format[i] != '{') continue;
    if (i + 1 < format.size() && format[i + 1] == '{') {
      ++i;
      continue;
    }
    const std::size_t end = format.find('}', i);
    if (end == std::string_view::npos || !is_modest(format.substr(i + 1, end - i - 1))) return false;
    i = end;
  }
  return true;
}

/// Converts a printf() format into a format of fmt. Stops at the first conversion that is not supported. This
/// conversion and the rest of the format appear unchanged in the text.
std::string translated(std::string_view format) {
  std::string text;
  for (std::size_t i = 0; i < format.size(); ++i) {
    const char c = format[i];
    if (c == '{' || c == '}') text += c;
    if (c != '%') {
      text += c;
      continue;
    }
    const auto take = [&format, &i](std::string_view of) {
      const std::size_t begin = i + 1;
      while (i + 1 < format.size() && of.find(format[i + 1]) != std::string_view::npos) ++i;
      return format.substr(begin, i + 1 - begin);
    };
    const std::size_t begin = i;
    const std::string_view flags = take("-+ #0");
    const std::string_view width = take("0123456789");
    const std::string_view precision = take("0123456789.");
    take("hlzjt");
    if (++i < format.size() && format[i] == '%') {
      text += '%';
      continue;
    }
    if (i >= format.size() || std::string_view{"diuxXocfFeEgGs"}.find(format[i]) == std::string_view::npos) {
      for (const char rest : format.substr(begin))
        text += std::string(rest == '{' || rest == '}' ? 2 : 1, rest);
      return text;
    }
    const auto has = [flags](char flag) { return flags.find(flag) != std::string_view::npos; };
    text += "{:";
    if (has('-') && !width.empty())
      text += '<';
    else if (!width.empty() && !has('0'))
      text += '>';
    if (has('+'))
      text += '+';
    else if (has(' '))
      text += ' ';
    if (has('#')) text += '#';
    if (has('0') && !has('-')) text += '0';
    text.append(width).append(precision);
    text += std::string_view{"iu"}.find(format[i]) != std::string_view::npos ? 'd' : format[i];
    text += '}';
  }
  return text;
}

/// Returns the format unchanged, followed by the arguments.
std::string unformatted(const Copy& copy) {
  if (copy.count == 0) return copy.format;
  std::string places = "{}";
  for (std::size_t i = 1; i < copy.count; ++i) places += ", {}";
  return copy.format + " (this format does not fit its arguments: " + fmt::vformat(places, copy.arguments) +
         ")";
}

std::string text_of(const Copy& copy) {
  const std::string format = copy.percent ? translated(copy.format) : copy.format;
  std::string text;
  try {
    text = is_modest_format(format) ? fmt::vformat(format, copy.arguments) : unformatted(copy);
  } catch (const std::exception&) {  // for example, if the argument for {:d} is a text
    text = unformatted(copy);
  }
  if (text.size() > kMostText) {
    std::size_t end = kMostText;
    // Do not split a UTF-8 character.
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
    text.resize(end);
    text += " ...";
  }
  return on_one_line(text);
}

LogLine line_of(const LogRecord& record) {
  const std::array<char, LogRecord::kText> text = record.text;
  Copy copy{.format = text_at(text, 0, record.format_size),
            .percent = record.percent != 0,
            .count = std::min<std::size_t>(record.arguments, LogRecord::kArguments),
            .arguments = {}};
  for (std::size_t i = 0; i < copy.count; ++i) add(copy, record.kinds[i], record.values[i], text);
  LogLine line{.time_ns = record.time_ns, .release = record.cycle, .text = text_of(copy)};
  const std::uint8_t level = record.level;
  line.level = static_cast<LogLevel>(std::clamp<std::uint8_t>(level, 1, 4));
  return line;
}

}  // namespace

std::optional<LogLine> LogReader::next(Instant now) {
  LogRecord& record = ring_.records[read_ % channel::LogRing::kRecords];
  const std::uint64_t free = read_ / channel::LogRing::kRecords * 2;
  std::optional<LogLine> line;
  if (record.state.load(std::memory_order_acquire) == free + 1) {  // pairs with LogRing::add()
    line = line_of(record);
  } else {
    if (ring_.claimed.load(std::memory_order_relaxed) <= read_) {
      waits_since_.reset();
      return std::nullopt;
    }
    if (!waits_since_) waits_since_ = now;
    if (now - *waits_since_ < kPatience) return std::nullopt;
    ++skipped_;
  }
  waits_since_.reset();
  record.state.store(free + 2, std::memory_order_release);  // pairs with LogRing::add()
  ++read_;
  return line;
}

channel::LogCounts LogReader::lost() noexcept {
  channel::LogCounts lost{};
  for (std::size_t i = 0; i < lost.size(); ++i) {
    const std::uint64_t dropped = ring_.dropped[i].load(std::memory_order_relaxed);
    const std::uint64_t before = std::exchange(dropped_[i], dropped);
    lost[i] = dropped > before ? dropped - before : 0;
  }
  lost[0] += std::exchange(skipped_, 0);
  return lost;
}

}  // namespace takt::host
