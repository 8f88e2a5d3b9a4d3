#include "answers.hpp"

#include <array>
#include <chrono>
#include <cstdio>
#include <random>

#include <nlohmann/json.hpp>

#include <takt/client/answer_data.hpp>
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

Result<model::CellPorts> ports_of(const model::Cell& cell, const std::vector<wire::WholeReply>& replies) {
  model::CellPorts ports;
  for (const model::Device& device : cell.devices) ports.emplace_back(device.modules.size());
  for (const wire::WholeReply& reply : replies) {
    const auto of_reply = [&](const json& data) {
      for (const json& entry : data.value("modules", json::array())) {
        const auto name = entry.at("name").get<std::string>();
        if (!entry.contains("ports") || entry.at("ports").is_null()) continue;
        auto known = model::parse_ports(model::json_text(entry.at("ports")));
        for (std::size_t d = 0; known && d < cell.devices.size(); ++d) {
          const model::Device& device = cell.devices[d];
          for (std::size_t m = 0; reply.head.device() == device.name && m < device.modules.size(); ++m) {
            if (device.modules[m].name == name) ports[d][m] = *known;
          }
        }
      }
    };
    if (const auto read = read_answer(reply.head.device().to_string(), reply.data, of_reply); !read)
      return read.problems();
  }
  return ports;
}

}  // namespace takt::client
