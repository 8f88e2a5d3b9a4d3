// Simulated cells for tests. A test builds a cell from a descriptor, runs it with a script, and reads what
// happened as text.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include <folders.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/simulation/simulation.hpp>

namespace takt::simulation::simulated {

class Text final : public Listener {
 public:
  explicit Text(std::vector<const model::Cell*> versions) : versions_(std::move(versions)) {}
  void on_event(const Event& event) override {
    lines.push_back(to_text(event, *versions_.at(event.version), kT0));
  }
  std::vector<std::string> lines;

 private:
  std::vector<const model::Cell*> versions_;
};

struct Outcome {
  std::vector<std::string> lines;
  Course course;
};

/// A cell that was read from a descriptor, with the plans of its devices.
class Cell {
 public:
  static Cell demo() {
    auto cell = descriptor::load(source_path("deploy/palletizing.xml"));
    return Cell{std::move(*cell)};
  }
  static Cell of(const std::string& devices, const std::string& file = "cell.xml") {
    auto cell = descriptor::parse("<cell name=\"c\">" + devices + "</cell>", file);
    if (!cell) ADD_FAILURE() << to_text(cell.problems());
    return Cell{std::move(*cell)};
  }
  [[nodiscard]] Outcome run(Options options, const std::string& script = "") const {
    auto faults = parse_script(script, "script", cell_);
    if (!faults) ADD_FAILURE() << to_text(faults.problems());
    options.injections = *faults;
    Text text{{&cell_, options.update == nullptr ? &cell_ : &options.update->cell}};
    if (options.listener == nullptr) options.listener = &text;
    auto course = simulate(cell_, plans_, {}, options);
    EXPECT_TRUE(course.ok());
    EXPECT_THAT(course->violations, testing::IsEmpty());
    return {std::move(text.lines), std::move(*course)};
  }
  [[nodiscard]] const model::Cell& model() const { return cell_; }
  /// The cell as an update.
  [[nodiscard]] Version version() const { return {.cell = cell_, .plans = plans_}; }

 private:
  explicit Cell(model::Cell cell) : cell_(std::move(cell)), plans_(*schedule::plan(cell_)) {}
  model::Cell cell_;
  std::vector<schedule::DevicePlan> plans_;
};

inline std::string thread(const std::string& name, const std::string& period, const std::string& more = "") {
  return "<module><name>" + name +
         "</name><filename>x.so</filename><moduletype>thread</moduletype>"
         "<operationtype>periodic</operationtype><period>" +
         period + "</period><priority>1</priority>" + more + "</module>";
}

inline std::string program(const std::string& name, const std::string& period, const std::string& more = "") {
  return "<module><name>" + name +
         "</name><filename>x.exe</filename><moduletype>process</moduletype>"
         "<operationtype>periodic</operationtype><period>" +
         period + "</period><priority>1</priority>" + more + "</module>";
}

inline const nlohmann::ordered_json& module_of(const Outcome& run, const std::string& name) {
  for (const auto& device : run.course.report["devices"]) {
    for (const auto& module : device["modules"]) {
      if (module["name"] == name) return module;
    }
  }
  static const nlohmann::ordered_json none;
  return none;
}

inline std::vector<std::string> steps_of(const Outcome& run, const std::string& who) {
  std::vector<std::string> steps;
  for (const std::string& line : run.lines) {
    if (line.find(" " + who + " ") == std::string::npos || line.find(" -> ") == std::string::npos) continue;
    const std::string step = line.substr(line.find(" -> ") + 4);
    steps.push_back(step.substr(0, step.find(',')));
  }
  return steps;
}

}  // namespace takt::simulation::simulated
