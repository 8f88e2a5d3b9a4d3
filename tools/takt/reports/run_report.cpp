#include "reports/run_report.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <takt/model/build.hpp>
#include <takt/model/json.hpp>
#include <takt/wire/judgement.hpp>

#include "reports/page.hpp"

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

// How far the device's clock is ahead of the clock of the first device of the cell; empty if this is not
// known.
std::string clock_text(const Json& device) {
  const Json clock = device.value("clock", Json{});
  if (!clock.is_object() || clock["reference"] == device["name"]) return "";
  return fmt::format("  clock {:+.1f} ms ±{:.1f} ms", clock["offset_us"].get<double>() / 1000,
                     clock["bound_us"].get<double>() / 1000);
}

// The node's judgement of a port: "! degraded: drops samples" in amber, "X stale" in red, or "  ok".
std::string judgement_text(const Json& port, Style style) {
  const std::string rating = port.value("rating", "");
  if (rating.empty()) return "";
  const bool good = rating == wire::to_text(wire::Rating::good);
  const bool poor = rating == wire::to_text(wire::Rating::poor);
  const std::string text =
      (good ? "  " : mark_of(poor ? wire::Rating::poor : wire::Rating::bad)) + port.value("reason", "");
  return style.colour && !good ? fmt::format(" \033[{}m{}\033[0m", poor ? 33 : 31, text) : " " + text;
}

// A table of the device's connected ports.
std::string ports_text(const Json& device, Style style) {
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
  const bool judged =
      std::any_of(rows.begin(), rows.end(), [](const Row& row) { return row.port->contains("rating"); });
  std::string text =
      fmt::format("  {:<{}} {:<5} {:>7} {:>10} {:>7} {:>7} {:>6} {:>10}{}\n", "port", width, "", "matched",
                  "samples", "lost", "dropped", "late", "age", judged ? "   now" : "");
  for (const auto& [name, pointer] : rows) {
    const Json& p = *pointer;
    const auto count = [&p](const char* key) { return p[key].get<std::uint64_t>(); };
    text += fmt::format("  {:<{}} {:<5} {:>7} {:>10} {:>7} {:>7} {:>6} {:>10}{}\n", name, width,
                        p["direction"].get<std::string>(),
                        fmt::format("{}/{}", count("matched"), count("connections")), count("samples"),
                        count("lost"), count("dropped"), count("late"),
                        p["age_us"].is_null() ? "-" : us(p["age_us"]), judgement_text(p, style));
  }
  return text;
}

// A table of the modules' component files.
std::string components_text(const Json& device, std::size_t width) {
  std::string text;
  for (const Json& m : device["modules"]) {
    if (!m.contains("hash")) continue;
    if (text.empty())
      text = fmt::format("  {:<{}} {:<8} {:<12} {}\n", "component", width, "hash", "version", "file");
    const std::string version = m["version"].get<std::string>();
    text += fmt::format("  {:<{}} {:<8} {:<12} {}\n", m["name"].get<std::string>(), width,
                        m["hash"].get<std::string>(), version.empty() ? "-" : version,
                        m["file"].get<std::string>());
  }
  return text;
}

std::string state_of(const Json& device, const Json& module) {
  const auto state = module["state"].get<std::string>();
  return state_text(state, module.value("stopped", false) && device.value("state", "") == "running");
}

std::string device_text(const Json& device, std::size_t width, Style style) {
  // Name the device's state only if the device is not running.
  std::string state = device.value("state", "");
  if (state == "running") state.clear();
  const std::string why = one_line(device.value("text", ""));
  if (!why.empty()) state += (state.empty() ? "" : ": ") + why;
  if (!state.empty()) state.insert(0, "  ");
  state.insert(0, clock_text(device));
  if (const auto alarms = device.value("unacknowledged_alarms", std::size_t{0}); alarms > 0)
    state += "\n  " + count(alarms, "unacknowledged alarm") + "; takt alarms lists them";
  if (const std::string conflict = device.value("conflict", ""); !conflict.empty())
    state += "\n  NAME CONFLICT: " + conflict;
  std::string text = fmt::format(
      "device {}{}{}{}\n", device["name"].get<std::string>(), device["alive"].get<bool>() ? "" : "  LOST",
      device["real_time"].get<bool>() || !device["alive"].get<bool>() ? "" : "  NOT REAL-TIME", state);
  if (!device["alive"].get<bool>()) {
    for (const Json& m : device["modules"]) {
      text += fmt::format("  {:<{}} {}\n", m["name"].get<std::string>(), width,
                          lost_text(m["state"].get<std::string>()));
    }
    return text + "  " + wire::kLostRemedy + "\n";
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
  std::size_t state_width = 10;
  for (const Json& m : device["modules"]) state_width = std::max(state_width, state_of(device, m).size());
  text += fmt::format("  {:<{}} {:<{}} {:>9} {:>9} {:>7} {:>7} {:>8} {:>8} {:>8} {:>6}\n", "module", width,
                      "state", state_width, "cycles", "jitter", "p50", "p99", "run p50", "run max",
                      "overruns", "errors");
  for (const Json& m : device["modules"]) {
    const Json& j = m["jitter_us"];
    text += fmt::format("  {:<{}} {:<{}} {:>9} {:>9} {:>7} {:>7} {:>8} {:>8} {:>8} {:>6}\n",
                        m["name"].get<std::string>(), width, state_of(device, m), state_width,
                        m["cycles"].get<std::uint64_t>(), us(j["mean"]), us(j["p50"]), us(j["p99"]),
                        us(m["run_us"]["p50"]), us(m["run_us"]["max"]), m["overruns"].get<std::uint64_t>(),
                        m["errors"].get<std::uint64_t>());
    if (const std::string text_of = one_line(m.value("text", "")); !text_of.empty())
      text += "    " + text_of + "\n";
  }
  return text + components_text(device, width) + ports_text(device, style);
}

}  // namespace

std::map<std::string, std::string> components_in(const Json& device) {
  std::map<std::string, std::string> components;
  for (const Json& m : device.at("modules")) {
    if (!m.contains("hash")) continue;
    const auto path = m.at("file").get<std::string>();
    const model::Build build{.version = m.at("version"), .hash = m.at("hash")};
    components[m.at("name")] = path.substr(path.rfind('/') + 1) + " " + model::to_text(build);
  }
  return components;
}

void leave_out_components(Json& status) {
  for (Json& device : status["devices"]) {
    for (Json& m : device["modules"]) {
      for (const char* member : {"file", "version", "hash"}) m.erase(member);
    }
  }
}

std::string run_text(const Json& status, Style style) {
  std::size_t width = 8;
  for (const Json& device : status["devices"]) {
    for (const char* list : {"executors", "modules"}) {
      for (const Json& entry : device[list]) width = std::max(width, entry["name"].get<std::string>().size());
    }
  }
  std::string text = fmt::format("\ncell {}\n", status["cell"].get<std::string>());
  for (const Json& device : status["devices"]) text += device_text(device, width, style);
  for (const Json& line : status.value("differences", Json::array()))
    text += "DIFFERENT DEPLOYMENTS: " + line.get<std::string>() + "\n";
  return text +
         "\n  Times are in us; a late start has a negative jitter. takt status --help explains the "
         "columns.\n";
}

std::string run_json(Json status) {
  for (Json& device : status["devices"]) {
    for (Json& executor : device["executors"]) executor.erase("margin_us");
  }
  return model::json_text(status) + "\n";
}

}  // namespace takt::tool
