// Functions that make snapshots of cells for tests, and that draw a screen as text.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <watch/screen.hpp>

namespace takt::tool::watch {

inline Module module(const std::string& name, const std::string& state = "EXECUTING") {
  Module module{.name = name, .state = state};
  module.measured = Measured{.cycles = 1000, .jitter_us = {.p50 = 1.5, .p99 = 20.25}, .run_us = {.p99 = 50}};
  return module;
}

inline Device device(const std::string& name, std::vector<Module> modules = {}) {
  return {.name = name,
          .cell = modules.empty() ? "" : "cell",
          .state = modules.empty() ? "waiting" : "running",
          .health = "ok",
          .modules = std::move(modules)};
}

/// Returns a snapshot of two devices: "line" has one module, which is in RECOVER; "robot" has `modules`
/// modules, named m0, m1 and so on.
inline Snapshot cell(std::size_t modules) {
  std::vector<Module> many;
  for (std::size_t i = 0; i < modules; ++i) many.push_back(module("m" + std::to_string(i)));
  Snapshot snapshot{
      .domain = 7, .clock = "12:34:56", .devices = {device("line", {module("belt", "RECOVER")})}};
  snapshot.devices[0].modules[0].text = "failure: it jams";
  snapshot.devices.push_back(device("robot", many));
  return snapshot;
}

inline std::string text_of(const Screen& screen) {
  std::string text;
  for (const std::string& line : screen.lines) text += line + "\n";
  return text;
}

inline std::string drawn(const Snapshot& snapshot, View view = {}, std::size_t columns = 80,
                         std::size_t lines = 24, ScreenStyle style = {}) {
  return text_of(draw(snapshot, view, columns, lines, style));
}

}  // namespace takt::tool::watch
