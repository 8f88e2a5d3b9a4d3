// Parses the recorder's properties. Each argument of the program is one property: name=value.
#pragma once

#include <array>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include <takt/core/result.hpp>
#include <takt/core/words.hpp>

#include <takt/recording/recorder.hpp>

namespace takt::tool {

inline std::vector<std::string> words_of(const std::string& text) {
  constexpr const char* kSpace = " \t\r\n,";
  std::vector<std::string> words;
  for (std::size_t at = text.find_first_not_of(kSpace); at != std::string::npos;) {
    const std::size_t end = std::min(text.find_first_of(kSpace, at), text.size());
    words.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(kSpace, end);
  }
  return words;
}

/// Returns the options, or all errors at once.
inline Result<recording::RecordOptions> parse_properties(const std::vector<std::string>& arguments) {
  constexpr std::array<std::string_view, 9> kKnown{"ports",  "file",   "max_size", "full",  "flush",
                                                   "append", "domain", "peers",    "server"};
  recording::RecordOptions options;
  options.who = "recorder";
  Problems problems;
  const auto wrong = [&](const std::string& name, const std::string& value, std::string fix) {
    problems.push_back({"property " + name, "cannot be " + in_quotes(value), std::move(fix)});
  };
  const auto number = [&](const std::string& name, const std::string& value, double from, double to) {
    char* end = nullptr;
    const double read = std::strtod(value.c_str(), &end);
    if (!value.empty() && *end == '\0' && read >= from && read <= to) return read;
    wrong(name, value, fmt::format("write a number from {} to {}", from, to));
    return from;
  };
  for (const std::string& argument : arguments) {
    const std::size_t equal = argument.find('=');
    const std::string name = argument.substr(0, equal);
    const std::string value = equal == std::string::npos ? "" : argument.substr(equal + 1);
    if (name == "ports") {
      options.ports = words_of(value);
    } else if (name == "file") {
      options.recording.file = value;
    } else if (name == "max_size") {
      options.recording.max_bytes = static_cast<std::uint64_t>(number(name, value, 0, 1e9) * 1e6);
    } else if (name == "full") {
      if (value != "stop" && value != "oldest") wrong(name, value, "write stop or oldest");
      options.recording.full = value == "oldest" ? recording::Full::oldest : recording::Full::stop;
    } else if (name == "flush") {
      options.recording.flush = Nanoseconds{static_cast<std::int64_t>(number(name, value, 0.01, 3600) * 1e9)};
    } else if (name == "append") {
      if (value != "true" && value != "false") wrong(name, value, "write true or false");
      options.recording.append = value == "true";
    } else if (name == "domain") {
      options.network.domain = static_cast<int>(number(name, value, 0, 232));
    } else if (name == "peers") {
      options.network.peers = value;
    } else if (name == "server") {
      options.network.server = value;
    } else {
      problems.push_back(
          fail("unknown property " + in_quotes(name), suggestion(name, {kKnown.begin(), kKnown.end()})));
    }
  }
  if (options.ports.empty())
    problems.push_back({"property ports", "is missing",
                        "write the names of ports, separated by spaces, as in line.conveyor.state robot.*"});
  if (options.recording.file.empty())
    problems.push_back({"property file", "is missing", "write the path of the file to record to"});
  if (problems.empty()) return options;
  return problems;
}

}  // namespace takt::tool
