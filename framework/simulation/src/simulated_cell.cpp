#include "simulated_cell.hpp"

#include <algorithm>
#include <string>

#include <takt/core/check.hpp>
#include <takt/model/safe.hpp>
#include "simulated_link.hpp"

namespace takt::simulation {

namespace {

constexpr std::uint32_t kEncapsulation = 4;  // size of the CDR header before a sample, in bytes

model::Type sample_type(const std::string& name) {
  auto type = model::parse_type(
      R"({"name":"takt::simulation::Sample","fields":[{"name":"bytes","type":"octet","array":[)" +
      std::to_string(kSampleBytes - kEncapsulation) + "]}]}");
  TAKT_CHECK(type && model::max_size(*type) == kSampleBytes);
  type->name = name;
  return *type;
}

std::string safe_sample() {
  std::string zeros = "0";
  for (std::uint32_t i = 1; i < kSampleBytes - kEncapsulation; ++i) zeros += ",0";
  return R"({"bytes":[)" + zeros + "]}";
}

bool has_safe_value(const model::Module& module, const std::string& port, const model::Port* known) {
  if (known != nullptr) return !model::read_safe(module, *known).json.empty();
  return std::any_of(module.safe.begin(), module.safe.end(),
                     [&](const model::SafeValue& safe) { return safe.name == port; });
}

}  // namespace

std::vector<std::uint32_t> ConnectionNumbers::of(const model::Cell& cell) {
  std::vector<std::uint32_t> numbers;
  for (const model::Connection& connection : cell.connections) {
    const auto next = static_cast<std::uint32_t>(known_.size());
    const auto ends = std::pair{model::to_text(connection.from), model::to_text(connection.to)};
    numbers.push_back(known_.try_emplace(ends, next).first->second);
  }
  return numbers;
}

SimulatedCell simulated_cell(const model::Cell& cell, const model::CellPorts& ports) {
  SimulatedCell simulated{.cell = cell, .ports = {}};
  const auto add = [&](const model::Endpoint& end, bool output) {
    for (std::size_t d = 0; d < cell.devices.size(); ++d) {
      if (cell.devices[d].name != end.device) continue;
      for (std::size_t m = 0; m < cell.devices[d].modules.size(); ++m) {
        const model::Module& module = cell.devices[d].modules[m];
        if (module.name != end.module) continue;
        auto& all = *simulated.ports[d][m];
        if (std::any_of(all.begin(), all.end(),
                        [&](const model::Port& port) { return port.name == end.port; }))
          continue;
        const model::Port* const known = model::find_port(cell, ports, end);
        model::Port port;
        port.name = end.port;
        port.type = sample_type(known == nullptr ? "" : known->type.name);
        if (module.operation == model::Operation::sporadic) port.direction = model::Direction::event;
        if (known != nullptr) port.direction = known->direction;
        if (output) port.direction = model::Direction::out;
        if (output && has_safe_value(module, end.port, known)) port.safe = safe_sample();
        all.push_back(std::move(port));
      }
    }
  };
  for (model::Device& device : simulated.cell.devices) {
    simulated.ports.emplace_back(device.modules.size(), std::vector<model::Port>{});
    for (model::Module& module : device.modules) module.safe.clear();
  }
  for (std::size_t i = 0; i < simulated.cell.connections.size(); ++i) {
    model::Connection& connection = simulated.cell.connections[i];
    if (connection.from.given()) add(connection.from, true);
    if (connection.to.given()) add(connection.to, false);
    connection.carries = model::Carries::samples;
    const bool within = connection.from.given() && connection.to.given() &&
                        connection.from.device == connection.to.device && connection.topic.empty();
    if (!within) connection.topic = "connection/" + std::to_string(i);
  }
  return simulated;
}

}  // namespace takt::simulation
