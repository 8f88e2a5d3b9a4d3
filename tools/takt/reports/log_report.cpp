#include "reports/log_report.hpp"

#include <algorithm>
#include <cstring>
#include <ctime>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/core/words.hpp>
#include <takt/model/json.hpp>

namespace takt::tool {

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

std::tm local(std::int64_t wall_ns) {
  const std::time_t seconds = wall_ns / kSecond;
  std::tm time{};
  ::localtime_r(&seconds, &time);
  return time;
}

const char* colour_of(model::Severity severity) {
  switch (severity) {
    case model::Severity::note:
      return "\033[32m";
    case model::Severity::warning:
      return "\033[33m";
    case model::Severity::error:
      return "\033[31m";
  }
  return "";
}

/// The character that marks the severity, so that it is visible without colours.
char mark_of(model::Severity severity) {
  switch (severity) {
    case model::Severity::note:
      return ' ';
    case model::Severity::warning:
      return '!';
    case model::Severity::error:
      return 'X';
  }
  return '?';
}

// The number of terminal columns that a text needs; each character takes one.
std::size_t printed_columns(std::string_view text) {
  std::size_t columns = 0;
  for (; !text.empty(); ++columns) text.remove_prefix(std::max<std::size_t>(utf8_length(text), 1));
  return columns;
}

// Wraps a text at spaces to `width` columns. A word that is longer gets its own line.
std::vector<std::string> lines_of(const std::string& text, std::size_t width) {
  std::vector<std::string> lines;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view word = rest.substr(0, rest.find(' '));
    rest.remove_prefix(std::min(word.size() + 1, rest.size()));
    if (word.empty()) continue;
    if (lines.empty() || printed_columns(lines.back()) + 1 + printed_columns(word) > width)
      lines.emplace_back(word);
    else
      lines.back().append(" ").append(word);
  }
  return lines;
}

// The severity or kind in its colour, filled with spaces up to `width`.
std::string coloured(const std::string& text, std::size_t width, model::Severity severity, Style style) {
  const std::string padded = fmt::format("{:<{}}", text, width);
  if (!style.colour) return padded;
  return colour_of(severity) + text + "\033[0m" + padded.substr(std::min(text.size(), padded.size()));
}

std::string indented(const std::string& text, std::size_t indent, std::size_t width) {
  std::string result;
  for (const std::string& line : lines_of(text, width - indent))
    result += std::string(indent, ' ') + line + "\n";
  return result;
}

std::string date_of(const std::tm& time) {
  return fmt::format("{:04}-{:02}-{:02}", time.tm_year + 1900, time.tm_mon + 1, time.tm_mday);
}

std::string second_of(std::int64_t wall_ns) {
  const std::tm time = local(wall_ns);
  return fmt::format("{} {:02}:{:02}:{:02}", date_of(time), time.tm_hour, time.tm_min, time.tm_sec);
}

std::string name_of(const std::string& device, const std::string& module) {
  return device + (module.empty() ? "" : "." + module);
}

std::string cause_of(const model::Fault& fault) {
  std::string text = on_one_line(fault.cause);
  if (!fault.error.empty()) text = fault.error + ": " + text;
  if (fault.count != 1) text += fmt::format(" ({} times)", fault.count);
  if (!fault.module.empty() && fault.cycle != 0) {
    text += model::is_log_line(fault.kind)
                ? fmt::format(" [release {}]", fault.cycle)
                : fmt::format(" [after {} {}]", fault.cycle, fault.cycle == 1 ? "cycle" : "cycles");
  }
  if (!fault.attachment.empty()) text += "; see " + on_one_line(fault.attachment);
  return text;
}

}  // namespace

std::string log_text(const std::vector<model::Fault>& events, std::string& day, Style style) {
  const std::size_t width = std::clamp<std::size_t>(style.width, 80, 100);
  constexpr std::size_t kIndent = 15;
  std::string text;
  for (const model::Fault& fault : events) {
    const std::tm time = local(fault.time_ns);
    const std::string date = date_of(time);
    if (date != day) text += date + "\n";
    day = date;
    const model::Severity severity = model::severity_of(fault.kind);
    const std::string kind = coloured(model::to_text(fault.kind), 15, severity, style);
    const std::string head = fmt::format("{:02}:{:02}:{:02}.{:03} {} {:<16} ", time.tm_hour, time.tm_min,
                                         time.tm_sec, fault.time_ns % kSecond / 1'000'000, mark_of(severity),
                                         name_of(fault.device, fault.module));
    const std::string cause = cause_of(fault);
    text += head + kind;
    const std::size_t columns = std::max<std::size_t>(std::strlen(model::to_text(fault.kind)), 15);
    if (printed_columns(head) + columns + 1 + printed_columns(cause) <= width) {
      text += " " + cause + "\n";
      continue;
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += "\n" + indented(cause, kIndent, width);
  }
  return text;
}

std::string alarms_text(const std::vector<model::Alarm>& alarms, Style style) {
  const std::size_t width = std::clamp<std::size_t>(style.width, 80, 100);
  constexpr std::size_t kIndent = 4;
  std::string text;
  for (const model::Alarm& alarm : alarms) {
    const model::Severity severity = model::severity_of(alarm.kind);
    text += fmt::format("{} {:<16} {} {}, since {}\n", mark_of(severity), name_of(alarm.device, alarm.module),
                        coloured(model::to_text(alarm.kind), 15, severity, style), model::state_of(alarm),
                        second_of(alarm.since_ns));
    const model::Fault newest{.error = alarm.error, .cause = alarm.cause, .count = alarm.count};
    text += indented(cause_of(newest), kIndent, width);
    if (const auto& said = alarm.acknowledged)
      text +=
          indented(fmt::format("acknowledged by {} at {}{}", on_one_line(said->by), second_of(said->time_ns),
                               said->note.empty() ? "" : ": " + on_one_line(said->note)),
                   kIndent, width);
  }
  return text;
}

std::string log_json(const std::vector<model::Fault>& events) {
  std::string text;
  for (const model::Fault& fault : events) text += model::json_text(model::to_json(fault)) + "\n";
  return text;
}

Result<std::int64_t> since_from(const std::string& text, std::int64_t now_ns) {
  const auto wrong =
      fail(in_quotes(text) + " is not a valid time",
           "write an age (90s, 10m, 2h, 7d) or a point in time (14:30, 2026-03-01, 2026-03-01T14:30:05)");
  // An age, such as 10m.
  const std::size_t digits = text.find_first_not_of("0123456789");
  if (digits != std::string::npos && digits > 0 && digits < 10 && digits + 1 == text.size()) {
    const std::int64_t number = std::stoll(text.substr(0, digits));
    switch (text.back()) {
      case 's':
        return now_ns - number * kSecond;
      case 'm':
        return now_ns - number * 60 * kSecond;
      case 'h':
        return now_ns - number * 3600 * kSecond;
      case 'd':
        return now_ns - number * 86400 * kSecond;
      default:
        return wrong;
    }
  }
  // A point in time.
  for (const char* format : {"%Y-%m-%dT%H:%M:%S", "%Y-%m-%d %H:%M:%S", "%Y-%m-%dT%H:%M", "%Y-%m-%d %H:%M",
                             "%Y-%m-%d", "%H:%M:%S", "%H:%M"}) {
    std::tm time = local(now_ns);
    time.tm_sec = 0;
    if (format[1] == 'Y') time.tm_hour = time.tm_min = 0;
    const char* end = ::strptime(text.c_str(), format, &time);
    if (end == nullptr || *end != '\0') continue;
    time.tm_isdst = -1;
    const std::time_t seconds = std::mktime(&time);
    if (seconds == -1) return wrong;
    return static_cast<std::int64_t>(seconds) * kSecond;
  }
  return wrong;
}

}  // namespace takt::tool
