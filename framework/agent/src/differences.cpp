// Finds out what an update changes on this device, and whether it can be changed while the modules run.
#include "update.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include <takt/core/log_level.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/wire/words.hpp>

namespace takt::agent {

using json = nlohmann::ordered_json;
using model::Change;

namespace {

const model::Module* find_module(const model::Device& device, const std::string& name) {
  const auto found = std::find_if(device.modules.begin(), device.modules.end(),
                                  [&name](const model::Module& module) { return module.name == name; });
  return found == device.modules.end() ? nullptr : &*found;
}

bool same_property(const model::Module& one, const model::Module& other, const std::string& name) {
  const auto first = model::given_property(one, name);
  const auto second = model::given_property(other, name);
  return first.ok() == second.ok() && (!first || *first == *second);
}

/// Returns true if the component declares the property that the change sets. Only declared properties can be
/// set while a module runs; a module reads other properties only in initialize().
bool declares(const std::string& description, const model::ModuleChange& change) {
  const json all = model::parse_json(description);
  if (!all.is_object()) return false;
  for (const json& module : all.value("modules", json::array())) {
    if (module.value("name", "") != change.module) continue;
    for (const json& property : module.value("properties", json::array())) {
      if (property.value("name", "") == change.property) return true;
    }
  }
  return false;
}

model::ModulePorts ports_at(const Inspected& found, std::size_t module) {
  return module < found.ports.size() ? found.ports[module] : std::nullopt;
}
/// Returns true if both lists of ports can use the same links. Compares all properties on which the links
/// depend.
bool same_ports(const model::ModulePorts& before, const model::ModulePorts& after) {
  if (!before || !after) return !before && !after;
  return std::is_permutation(before->begin(), before->end(), after->begin(), after->end(),
                             [](const model::Port& one, const model::Port& other) {
                               return one.name == other.name && one.direction == other.direction &&
                                      one.object == other.object && one.role == other.role &&
                                      one.safe == other.safe &&
                                      model::difference(one.type, other.type).empty();
                             });
}

}  // namespace

std::size_t Agent::Deployment::index_of(const std::string& module) const {
  return static_cast<std::size_t>(find_module(of_device(), module) - of_device().modules.data());
}

void Agent::Deployment::inherit(const Deployment& other) {
  swapped.clear();
  set.clear();
  for (const model::Module& module : of_device().modules) {
    const model::Module* const was = find_module(other.of_device(), module.name);
    if (was == nullptr) continue;
    const auto exchanged = other.swapped.find(module.name);
    if (exchanged != other.swapped.end() && was->filename == module.filename)
      swapped[module.name] = exchanged->second;
    const auto values = other.set.find(module.name);
    if (values == other.set.end()) continue;
    for (const auto& [name, value] : values->second) {
      if (same_property(*was, module, name)) set[module.name][name] = value;
    }
  }
}

// Compares the running descriptor with the new one, without looking at the components.
Result<void> Agent::Update::compare() {
  Deployment& after = *after_;
  const auto has_device = agent_.read(after);
  if (!has_device) return has_device.problems();
  if (!agent_.deployment_) {
    if (!*has_device)
      return fail("cell " + after.cell.name + " has no device " + agent_.options_.device,
                  "deploy the cell only to its own devices");
    difference_ = {.device = agent_.options_.device, .change = Change::added};
    return {};
  }
  auto all = model::differences(agent_.deployment_->cell, after.cell);
  if (!all) return all.problems();
  for (model::DeviceDifference& one : *all) {
    if (one.device == agent_.options_.device) difference_ = std::move(one);
  }
  for (model::ModuleChange& one : difference_.in_place) {
    const auto& set = agent_.deployment_->set[one.module];
    const auto value = set.find(one.property);
    if (value != set.end()) one.words += " (an operator has set it to " + brief(value->second) + ")";
  }
  after.transaction.devices =
      model::device_names(agent_.deployment_->cell);  // until the client sends all devices
  if (difference_.change == Change::removed) after.text.clear();
  if (*has_device) after.inherit(*agent_.deployment_);
  return {};
}

void Agent::Update::inspect() {
  Deployment& after = *after_;
  if (difference_.change == Change::removed) return inspected(Inspected{});
  // If a change sets a property, the components must be described, because only their descriptions state
  // which properties can be set.
  const auto& in_place = difference_.in_place;
  const bool sets =
      std::any_of(in_place.begin(), in_place.end(), [](const auto& one) { return !one.property.empty(); });
  auto inspection = agent_.factories_.inspect({.text = after.text,
                                               .file = after.file,
                                               .device = agent_.options_.device,
                                               .as_written = agent_.options_.temporary,
                                               .describe = sets,
                                               .swapped = after.swapped});
  if (inspection)
    inspection_ = std::move(*inspection);
  else
    inspected(inspection.problems());
}

// Adds to the changes each module whose file has the same name as before, but different contents.
void Agent::Update::add_rebuilt(const Inspected& found) {
  for (const model::Module& module : after_->of_device().modules) {
    const auto& changes = difference_.in_place;
    const bool has_new_file = std::any_of(changes.begin(), changes.end(), [&module](const auto& one) {
      return one.module == module.name && one.property.empty();
    });
    const std::size_t index = agent_.deployment_->index_of(module.name);
    if (has_new_file || index >= builds_.size() || index >= found.builds.size()) continue;
    const model::Build& before = builds_[index];
    const model::Build& after = found.builds[index];
    if (before.hash.empty() || after.hash.empty() || before.hash == after.hash) continue;
    difference_.add_file(module, found.paths.at(index),
                         "file " + module.filename + ": " + to_text(before) + " -> " + to_text(after));
  }
}

// Checks, with the information from the components, whether the changes are possible while the modules run.
// If they are not, marks the device for a restart.
void Agent::Update::judge_in_place(const Inspected& found) {
  model::DeviceDifference& difference = difference_;
  for (const model::ModuleChange& one : difference.in_place) {
    const std::size_t index = agent_.deployment_->index_of(one.module);
    std::string why = "module " + one.module;
    const LifecycleStatus& module = agent_.deployment_->modules.at(index);
    if (one.property != kLogLevelProperty && is_given_up(module))
      why += " was given up";
    else if (one.property.empty() &&
             !same_ports(ports_at(agent_.deployment_->found, index), ports_at(found, index)))
      why += " has different ports in its new file";
    else if (!one.property.empty() && one.property != kLogLevelProperty && !declares(found.description, one))
      why += " reads property " + one.property + " only in initialize()";
    else
      continue;
    difference.make_anew(why);
    return;
  }
}

Result<void> Agent::Update::may_change_in_place() const {
  Problems problems;
  const Deployment& d = *agent_.deployment_;
  for (const model::ModuleChange& one : difference_.in_place) {
    const std::size_t index = d.index_of(one.module);
    const LifecycleState state = d.modules.at(index).state();
    if (one.property.empty()) {
      if (const auto may = d.supervised->may_swap(static_cast<std::uint32_t>(index)); !may)
        problems.insert(problems.end(), may.problems().begin(), may.problems().end());
    } else if (one.property != kLogLevelProperty && (state == STATE_IDLE || state == STATE_DESTRUCT)) {
      problems.push_back({"module " + agent_.options_.device + "." + one.module,
                          std::string{"it is in "} + takt::to_text(state) +
                              "; its properties can be set once it is in INITIALIZE",
                          "run takt restart " + agent_.options_.device + "." + one.module + " first"});
    }
  }
  if (!problems.empty()) return problems;
  return {};
}

}  // namespace takt::agent
