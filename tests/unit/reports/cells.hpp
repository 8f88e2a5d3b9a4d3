// Functions that build cells for the tests of reports.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <takt/model/cell.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::tool::cells {

using namespace std::chrono_literals;

inline model::Module periodic(std::string name, Nanoseconds period, int priority = 0) {
  model::Module module;
  module.name = std::move(name);
  module.period = period;
  module.priority = priority;
  module.executor = "main";
  return module;
}

inline model::Module sporadic(std::string name, Nanoseconds deadline, int priority = 0) {
  model::Module module = periodic(std::move(name), deadline, priority);
  std::swap(module.period, module.deadline);
  module.operation = model::Operation::sporadic;
  return module;
}

inline model::Module non_real(std::string name) {
  model::Module module;
  module.name = std::move(name);
  module.operation = model::Operation::non_real;
  return module;
}

inline model::Module process(model::Module module) {
  module.type = model::ModuleType::process;
  return module;
}

inline model::Module with_budget(model::Module module, Nanoseconds budget) {
  module.budget = budget;
  return module;
}

inline model::Module on(std::string executor, model::Module module) {
  module.executor = std::move(executor);
  return module;
}

inline model::Device device(std::string name, std::vector<model::Module> modules,
                            const std::vector<std::string>& executors = {"main"}) {
  model::Device result;
  result.name = std::move(name);
  for (const auto& executor : executors) result.executors.emplace_back().name = executor;
  result.modules = std::move(modules);
  return result;
}

inline model::Cell cell(std::string name, std::vector<model::Device> devices) {
  model::Cell result;
  result.name = std::move(name);
  result.file = "cell.xml";
  result.devices = std::move(devices);
  return result;
}

/// Returns the paper's Figure 1 as a cell.
inline model::Cell figure1() {
  return cell("module",
              {device("module", {periodic("controller1", 600us, 3), periodic("control2", 100us, 2),
                                 periodic("control3", 100us, 1), process(periodic("control4", 300us, 4)),
                                 sporadic("emergency", 100us, 1), process(sporadic("vision", 10ms, 2)),
                                 process(non_real("monitoring"))})});
}

/// Returns a cell of three devices and thirty modules, with modules of every kind.
inline model::Cell palletizing() {
  std::vector<model::Module> line;
  for (int i = 0; i < 12; ++i) {
    line.push_back(
        with_budget(periodic("conveyor" + std::to_string(i), 1ms * (1 << (i % 4)), i), 10us * (i + 1)));
  }
  line.push_back(sporadic("light_barrier", 5ms));
  auto robot =
      device("robot",
             {on("motion", with_budget(periodic("trajectory", 1ms, 1), 200us)),
              on("motion", with_budget(periodic("kinematics", 1ms, 2), 150us)),
              on("motion", with_budget(periodic("servo", 500us, 0), 80us)),
              on("motion", process(with_budget(periodic("collision_check", 4ms, 9), 3ms))),
              on("motion", with_budget(sporadic("emergency_stop", 500us, 0), 50us)),
              on("planning", periodic("task_planner", 20ms, 1)), on("planning", periodic("gripper", 5ms, 0)),
              on("planning", with_budget(periodic("payload_estimation", 10ms, 2), 2ms)),
              on("planning", process(sporadic("teach_pendant", 100ms))), process(non_real("logger"))},
             {"motion", "planning"});
  robot.executors[0].cpu = 1;
  auto vision =
      device("vision",
             {on("camera", process(periodic("camera_driver", 33ms, 0))),
              on("camera", process(periodic("segmentation", 66ms, 1))),
              on("camera", periodic("pose_filter", 11ms, 2)), on("events", sporadic("trigger", 8ms)),
              on("events", process(sporadic("calibration", 1s))), process(non_real("viewer")),
              non_real("statistics")},
             {"camera", "events", "spare"});
  return cell("palletizing", {robot, device("line", line), vision});
}

inline model::Module at_once(model::Module module) {
  module.dispatch = model::Dispatch::immediate;
  return module;
}

inline model::Module not_before(model::Module module, Nanoseconds interarrival) {
  module.interarrival = interarrival;
  return module;
}

/// Parses "device.module.port"; "" gives an empty endpoint.
inline model::Endpoint end(const std::string& text) {
  if (text.empty()) return {};
  const std::size_t first = text.find('.');
  const std::size_t second = text.find('.', first + 1);
  return {text.substr(0, first), text.substr(first + 1, second - first - 1), text.substr(second + 1)};
}

inline model::Connection latest(const std::string& from, const std::string& to) {
  model::Connection result;
  result.from = end(from);
  result.to = end(to);
  return result;
}

inline model::Connection queue(const std::string& from, const std::string& to, int depth) {
  model::Connection result = latest(from, to);
  result.kind = model::ConnectionKind::queue;
  result.depth = depth;
  result.reliability = model::Reliability::reliable;
  return result;
}

inline model::Connection stale_after(model::Connection connection, Nanoseconds deadline,
                                     model::Stale stale = model::Stale::hold) {
  connection.deadline = deadline;
  connection.stale = stale;
  return connection;
}

inline model::Connection on_topic(model::Connection connection, std::string topic) {
  connection.topic = std::move(topic);
  return connection;
}

inline model::Cell connected(model::Cell cell, std::vector<model::Connection> connections) {
  cell.connections = std::move(connections);
  return cell;
}

inline std::vector<schedule::DevicePlan> plans(const model::Cell& cell) {
  return schedule::plan(cell).value();
}

}  // namespace takt::tool::cells
