#include <takt/model/safe.hpp>

#include <algorithm>

#include <nlohmann/json.hpp>

#include <takt/core/hex.hpp>
#include <takt/core/words.hpp>
#include <takt/model/field_values.hpp>
#include <takt/model/json.hpp>

namespace takt::model {

namespace {

using Json = nlohmann::ordered_json;

std::string of_sample(const Type& type, const std::vector<std::byte>& bytes) {
  return is_sample(type, bytes.data(), bytes.size()) ? sample_json(type, bytes.data(), bytes.size()) : "";
}

const SafeValue* given_for(const Module& module, const std::string& port) {
  const auto found = std::find_if(module.safe.begin(), module.safe.end(),
                                  [&port](const SafeValue& safe) { return safe.name == port; });
  return found == module.safe.end() ? nullptr : &*found;
}

}  // namespace

SafeReading read_safe(const Module& module, const Port& port) {
  SafeReading reading{.json = port.safe, .problems = {}};
  const SafeValue* given = given_for(module, port.name);
  if (given == nullptr) return reading;
  Json value = reading.json.empty() ? Json::object() : parse_json(reading.json);
  std::vector<std::string> seen;
  for (const PropertyValue& field : given->fields) {
    const auto reject = [&](const Problems& problems) {
      for (const Problem& problem : problems) {
        reading.problems.emplace_back(field.line, fail("the safe value of port " + in_quotes(port.name) +
                                                           ": " + problem.where + " " + problem.what,
                                                       problem.fix));
      }
    };
    if (std::find(seen.begin(), seen.end(), field.name) != seen.end()) {
      reject({{port.type.name + "." + field.name, "is given twice", "give it one value"}});
      continue;
    }
    seen.push_back(field.name);
    const auto json = json_of_words(port.type, {field.name + "=" + field.value});
    if (!json) {
      reject(json.problems());
    } else if (const auto fits = sample_bytes(port.type, *json); !fits) {
      reject(fits.problems());
    } else {
      value.merge_patch(parse_json(*json));
    }
  }
  if (const auto bytes = sample_bytes(port.type, json_text(value)); bytes)
    reading.json = of_sample(port.type, *bytes);
  return reading;
}

std::vector<std::byte> safe_bytes(const Module& module, const Port& port) {
  const SafeReading reading = read_safe(module, port);
  if (reading.json.empty()) return {};
  auto bytes = sample_bytes(port.type, reading.json);
  return bytes ? std::move(*bytes) : std::vector<std::byte>{};
}

bool may_be_safe(const Connection& connection, const Port& to) {
  return connection.kind == ConnectionKind::latest && connection.from.given() &&
         connection.carries == Carries::samples && to.direction == Direction::in;
}

std::vector<SafeOutput> safe_outputs(const Cell& cell, const CellPorts& ports) {
  std::vector<SafeOutput> outputs;
  for (std::size_t d = 0; d < cell.devices.size() && d < ports.size(); ++d) {
    const Device& device = cell.devices[d];
    for (std::size_t m = 0; m < device.modules.size() && m < ports[d].size(); ++m) {
      if (!ports[d][m]) continue;
      for (const Port& port : *ports[d][m]) {
        if (port.direction != Direction::out || port.role != Role::plain) continue;
        std::string json = read_safe(device.modules[m], port).json;
        if (!json.empty())
          outputs.push_back({{device.name, device.modules[m].name, port.name}, std::move(json)});
      }
    }
  }
  return outputs;
}

std::string safe_json(const std::vector<SafeOutput>& outputs) {
  Json list = Json::array();
  for (const SafeOutput& output : outputs) {
    list.push_back({{"device", output.port.device},
                    {"module", output.port.module},
                    {"port", output.port.port},
                    {"safe", output.json}});
  }
  return json_text(list);
}

std::vector<SafeOutput> parse_safe(const std::string& text) {
  std::vector<SafeOutput> outputs;
  const Json list = parse_json(text);
  if (!list.is_array()) return outputs;
  for (const Json& each : list) {
    const auto text_of = [&each](const char* name) {
      return each.is_object() && each.contains(name) && each[name].is_string() ? each[name].get<std::string>()
                                                                               : "";
    };
    outputs.push_back({{text_of("device"), text_of("module"), text_of("port")}, text_of("safe")});
  }
  return outputs;
}

std::string safe_of_hex(const Type& type, const std::string& hex) {
  const auto bytes = bytes_of_hex(hex);
  return bytes ? of_sample(type, *bytes) : std::string{};
}

}  // namespace takt::model
