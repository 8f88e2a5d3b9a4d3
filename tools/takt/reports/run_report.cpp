#include "reports/run_report.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <takt/model/json.hpp>

namespace takt::tool {

namespace {

using Json = nlohmann::ordered_json;

// Formats microseconds with about three significant digits: 0.05, 12.3, 1450.
std::string us(const Json& value) {
  const double v = value.get<double>();
  const double size = v < 0 ? -v : v;
  return fmt::format("{:.{}f}", v, size < 10 ? 2 : size < 100 ? 1 : 0);
}

// The first line of a text that may have several lines.
std::string one_line(const std::string& text) { return text.substr(0, text.find('\n')); }

// A table of the device's connected ports.
std::string ports_text(const Json& device) {
  struct Row {
    std::string name;
    const Json* port;
  };
  std::vector<Row> rows;
  std::size_t width = 4;
  for (const Json& m : device["modules"]) {
    if (!m.contains("ports")) continue;
    for (const Json& port : m["ports"]) {
      if (port["connections"].get<std::uint64_t>() == 0) continue;
      rows.push_back({m["name"].get<std::string>() + "." + port["name"].get<std::string>(), &port});
      width = std::max(width, rows.back().name.size());
    }
  }
  if (rows.empty()) return "";
  std::string text = fmt::format("  {:<{}} {:<5} {:>7} {:>10} {:>7} {:>7} {:>6} {:>10}\n", "port", width, "",
                                 "matched", "samples", "lost", "dropped", "late", "age");
  for (const auto& [name, pointer] : rows) {
    const Json& p = *pointer;
    const auto count = [&p](const char* key) { return p[key].get<std::uint64_t>(); };
    text += fmt::format(
        "  {:<{}} {:<5} {:>7} {:>10} {:>7} {:>7} {:>6} {:>10}{}\n", name, width,
        p["direction"].get<std::string>(), fmt::format("{}/{}", count("matched"), count("connections")),
        count("samples"), count("lost"), count("dropped"), count("late"),
        p["age_us"].is_null() ? "-" : us(p["age_us"]),
        p["incompatible"].is_null() ? ""
                                    : "  not matched: incompatible " + p["incompatible"].get<std::string>());
  }
  return text;
}

std::string device_text(const Json& device, std::size_t width) {
  // Name the device's state only if the device is not running.
  std::string state = device.value("state", "");
  if (state == "running") state.clear();
  const std::string why = one_line(device.value("text", ""));
  if (!why.empty()) state += (state.empty() ? "" : ": ") + why;
  if (!state.empty()) state.insert(0, "  ");
  std::string text = fmt::format(
      "device {}{}{}{}\n", device["name"].get<std::string>(), device["alive"].get<bool>() ? "" : "  LOST",
      device["real_time"].get<bool>() || !device["alive"].get<bool>() ? "" : "  NOT REAL-TIME", state);
  if (!device["alive"].get<bool>()) {
    for (const Json& m : device["modules"]) {
      text += fmt::format("  {:<{}} {:<10} (last known state)\n", m["name"].get<std::string>(), width,
                          m["state"].get<std::string>());
    }
    return text;
  }
  if (device["executors"].empty() && device["modules"].empty()) return text;
  text += fmt::format("  {:<{}} {:>10} {:>8} {:>9} {:>8} {:>8} {:>8} {:>8}\n", "executor", width, "cycles",
                      "missed", "jitter", "p50", "p99", "max", "margin");
  for (const Json& e : device["executors"]) {
    const Json& j = e["jitter_us"];
    text +=
        fmt::format("  {:<{}} {:>10} {:>8} {:>9} {:>8} {:>8} {:>8} {:>8}\n", e["name"].get<std::string>(),
                    width, e["cycles"].get<std::uint64_t>(), e["missed"].get<std::uint64_t>(), us(j["mean"]),
                    us(j["p50"]), us(j["p99"]), us(j["max"]), us(e.value("margin_us", 0.0)));
  }
  text += fmt::format("  {:<{}} {:<10} {:>9} {:>9} {:>7} {:>7} {:>8} {:>8} {:>8} {:>6}\n", "module", width,
                      "state", "cycles", "jitter", "p50", "p99", "run p50", "run max", "overruns", "errors");
  for (const Json& m : device["modules"]) {
    const Json& j = m["jitter_us"];
    text += fmt::format("  {:<{}} {:<10} {:>9} {:>9} {:>7} {:>7} {:>8} {:>8} {:>8} {:>6}\n",
                        m["name"].get<std::string>(), width, m["state"].get<std::string>(),
                        m["cycles"].get<std::uint64_t>(), us(j["mean"]), us(j["p50"]), us(j["p99"]),
                        us(m["run_us"]["p50"]), us(m["run_us"]["max"]), m["overruns"].get<std::uint64_t>(),
                        m["errors"].get<std::uint64_t>());
    if (const std::string text_of = one_line(m.value("text", "")); !text_of.empty())
      text += "    " + text_of + "\n";
  }
  return text + ports_text(device);
}

}  // namespace

std::string run_text(const Json& status) {
  std::size_t width = 8;
  for (const Json& device : status["devices"]) {
    for (const char* list : {"executors", "modules"}) {
      for (const Json& entry : device[list]) width = std::max(width, entry["name"].get<std::string>().size());
    }
  }
  std::string text = fmt::format("\ncell {}\n", status["cell"].get<std::string>());
  for (const Json& device : status["devices"]) text += device_text(device, width);
  return text +
         "\n  Times are in us. jitter: release minus start, as a signed mean; p50, p99 and max are of the\n"
         "  absolute value. missed: rows skipped because the row before, or the wake-up, was too late.\n"
         "  margin: how long before a release the executor wakes up. overruns: runs that did not end before\n"
         "  the next release or the deadline. matched: connections whose writer and reader have found each\n"
         "  other, of all connections. lost: samples lost between writer and reader. dropped: samples\n"
         "  dropped because the queue was full. late: how often the newest value became older than its\n"
         "  deadline.\n";
}

std::string run_json(Json status) {
  for (Json& device : status["devices"]) {
    for (Json& executor : device["executors"]) executor.erase("margin_us");
  }
  return model::json_text(status) + "\n";
}

}  // namespace takt::tool
