#include "answers.hpp"

#include <array>
#include <chrono>
#include <cstdio>
#include <random>

#include <nlohmann/json.hpp>

#include <takt/core/time.hpp>
#include <takt/model/json.hpp>

namespace takt::client {

using json = nlohmann::ordered_json;

std::int64_t wall_ns() {
  return std::chrono::duration_cast<Nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string new_id() {
  std::random_device random;
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%08x%08x", random(), random());
  return digits.data();
}

Problems of_device(const std::string& device, Problems problems) {
  for (Problem& problem : problems) {
    const bool named =
        problem.where.find(device) != std::string::npos || problem.what.find(device) != std::string::npos;
    if (named) continue;
    if (problem.where.empty())
      problem.where = "device " + device;
    else
      problem.what = "device " + device + ": " + problem.what;
  }
  return problems;
}

model::CellPorts ports_of(const model::Cell& cell, const std::vector<wire::WholeReply>& replies) {
  model::CellPorts ports;
  for (const model::Device& device : cell.devices) ports.emplace_back(device.modules.size());
  for (const wire::WholeReply& reply : replies) {
    const json data = model::parse_json(reply.data);
    if (!data.is_object()) continue;
    for (const json& entry : data.value("modules", json::array())) {
      if (!entry.is_object() || !entry.contains("ports") || entry["ports"].is_null()) continue;
      auto known = model::parse_ports(model::json_text(entry["ports"]));
      for (std::size_t d = 0; known && d < cell.devices.size(); ++d) {
        const model::Device& device = cell.devices[d];
        for (std::size_t m = 0; reply.head.device() == device.name && m < device.modules.size(); ++m) {
          if (device.modules[m].name == entry.value("name", "")) ports[d][m] = *known;
        }
      }
    }
  }
  return ports;
}

void KeepAlive::send(Operator& asker, const std::vector<std::string>& devices,
                     const std::function<Question(CommandKind, const std::string& device)>& question) {
  constexpr std::chrono::seconds kEvery{4};
  constexpr std::chrono::milliseconds kAnswered{500};
  if (std::chrono::steady_clock::now() - last_ < kEvery) return;
  sent();
  std::vector<Question> questions;
  for (const std::string& device : devices) {
    questions.push_back(question(COMMAND_REPORT, device));
    questions.back().limit = kAnswered;
  }
  static_cast<void>(asker.ask(questions));
}

}  // namespace takt::client
