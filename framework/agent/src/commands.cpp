// The commands to an agent, and its answers.
#include <algorithm>
#include <charconv>
#include <memory>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/agent/problems_json.hpp>
#include <takt/core/span.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/wire/question.hpp>
#include <takt/wire/words.hpp>
#include "limits.hpp"
#include "update.hpp"

namespace takt::agent {

using json = nlohmann::ordered_json;
using Phase = Supervised::Phase;

void Agent::answer(const Command& command, ReplyCode code, const std::string& text, std::string data,
                   std::optional<lifecycle::State> state, const std::string& value) {
  wire::WholeReply reply;
  reply.head.id(command.id());
  wire::set(reply.head.device(), options_.device);
  wire::set(reply.head.node(), options_.node);
  reply.head.module_name(command.module_name());
  reply.head.code(code);
  if (state) reply.head.state(static_cast<LifecycleState>(*state));
  wire::set(reply.head.text(), text);
  wire::set(reply.head.value(), value);
  reply.data = std::move(data);
  publisher_.reply(reply);
  note_answer(command, code, text);
}

/// Answers a command to one module. If it was not carried out, the problem names the module.
void Agent::answer_outcome(const Command& command, const Outcome& outcome) {
  const Problem why{"module " + options_.device + "." + command.module_name().to_string(), outcome.text, ""};
  answer(command, outcome.code, outcome.text,
         outcome.code == REPLY_OK ? "" : model::json_text(problems_json({why})), outcome.state,
         outcome.value);
}

namespace {

/// Returns true if two nodes with the same device name could both carry out the command, or give different
/// answers. Returns false for a command that continues or ends a deployment or an update, because only the
/// node that has begun the deployment or update can carry out such a command; and for the request for a
/// report, which shows the conflict.
bool is_ambiguous(const Command& command) {
  switch (command.kind()) {
    case COMMAND_UNDEPLOY:
      return command.deployment().size() == 0;
    case COMMAND_CHANGE:
    case COMMAND_RUN:
    case COMMAND_PUT_BACK:
    case COMMAND_REPORT:
      return false;
    default:
      return true;
  }
}

}  // namespace

void Agent::receive(const wire::WholeCommand& command) {
  const Command& head = command.head;
  const Nanoseconds late = span(head.deadline_ns(), options_.wall_ns());
  // The agent answers a question even after its deadline, so that a device whose clock differs can be
  // observed.
  if (head.deadline_ns() != 0 && late > Nanoseconds{0} && !wire::is_question(head.kind())) {
    answer(head, REPLY_LATE,
           std::string{takt::to_text(head.kind())} + " arrived " + takt::to_text(late) +
               " after its deadline; synchronise the clocks of the devices, or allow the command more time");
    return;
  }
  if (!name_clash_.empty() && is_ambiguous(head)) {
    std::vector<DeviceStatus> nodes{published_};
    for (const wire::ObservedDevice& other : others_.devices(options_.device)) {
      if (other.alive && other.node() != options_.node) nodes.push_back(other.status);
    }
    return answer(head, REPLY_REFUSED,
                  wire::nodes_of_one_name(nodes, options_.domain) + "; end all but one of them");
  }
  switch (head.kind()) {
    case COMMAND_REPORT:
      return report(head);
    case COMMAND_DESCRIPTOR:
      return descriptor(head);
    case COMMAND_DESCRIBE:
      return describe(head);
    case COMMAND_PREPARE:
      return prepare(command);
    case COMMAND_CHANGE:
      if (Update* const update = update_of(head)) update->change(command);
      return;
    case COMMAND_RUN:
      if (Update* const update = update_of(head)) update->run(head);
      return;
    case COMMAND_PUT_BACK:
      return put_back(head);
    case COMMAND_UNDEPLOY:
      return undeploy(head);
    case COMMAND_INITIALIZE:
      return command_module(head, Verb::initialize);
    case COMMAND_START:
      return command_module(head, Verb::start);
    case COMMAND_STOP:
      return command_module(head, Verb::stop);
    case COMMAND_RECOVER:
      return command_module(head, Verb::recover);
    case COMMAND_RESET:
      return command_module(head, Verb::reset);
    case COMMAND_DESTRUCT:
      return command_module(head, Verb::destruct);
    case COMMAND_GET:
    case COMMAND_SET:
      return property(head);
    case COMMAND_TAP:
      return tap(head);
    case COMMAND_LOG:
      return send_log(command);
    case COMMAND_TRACE:
      return trace(head);
    case COMMAND_SWAP:
      return swap(head);
    case COMMAND_FORCE:
      return force(command);
    case COMMAND_END_FORCE:
      return end_force(command);
    case COMMAND_ALARMS:
      return send_alarms(head);
    case COMMAND_ACKNOWLEDGE:
      return acknowledge(command);
  }
  answer(head, REPLY_REFUSED,
         "this node does not know command number " + std::to_string(static_cast<std::uint32_t>(head.kind())));
}

void Agent::report(const Command& command) {
  // While this device waits for slower devices, `takt deploy` sends this request as a keep-alive.
  if (update_ && update_->after().id == command.deployment().to_string()) update_->renew();
  json report{{"name", options_.device},
              {"alive", true},
              {"real_time", options_.real_time},
              {"executors", json::array()},
              {"modules", json::array()}};
  if (deployment_ && deployment_->supervised) {
    report = deployment_->supervised->report();
    const Inspected& found = deployment_->found;
    for (std::size_t i = 0; i < std::min(report["modules"].size(), found.builds.size()); ++i) {
      report["modules"][i]["file"] = found.paths.at(i);
      report["modules"][i]["version"] = found.builds[i].version;
      report["modules"][i]["hash"] = found.builds[i].hash;
    }
  }
  const DeviceStatus now = status();
  const Deployment* const d = present();
  report["cell"] = d != nullptr ? json(d->cell.name) : json(nullptr);
  report["deployment"] = d != nullptr ? json(d->id) : json(nullptr);
  report["update"] =
      deployment_ && !deployment_->update().empty() ? json(deployment_->update()) : json(nullptr);
  report["stage"] = newest_transaction() != nullptr ? json(takt::to_text(now.stage())) : json(nullptr);
  report["state"] = takt::to_text(now.state());
  if (!name_clash_.empty()) report["conflict"] = name_clash_;
  if (now.text().size() != 0 && now.text().to_string() != name_clash_)
    report["text"] = now.text().to_string();
  report["unacknowledged_alarms"] = alarms_.unacknowledged().size();
  report["lost"] = lost_devices();
  report["devices"] = d != nullptr ? json(model::device_names(d->cell)) : json::array();
  report["heard"] = json::array();
  for (const wire::ObservedDevice& other : others_.devices()) {
    if (other.alive) report["heard"].push_back(other.node());
  }
  report["clock"] = clock_report();
  report["searching"] = options_.now() - began_ < kFindsOthers;
  answer(command, REPLY_OK, "", model::json_text(report));
}

// Returns the lost devices of this cell, with the states of their modules that this node received last, and
// the lost devices that still have a cell that was undeployed here. A program that starts after the loss
// cannot get these states from the lost devices themselves.
json Agent::lost_devices() const {
  json list = json::array();
  for (const wire::ObservedDevice& other : others_.devices()) {
    if (other.alive || !was_undeployed(other.status.deployment().to_string())) continue;
    list.push_back(
        {{"name", other.name()},
         {"modules", json::array()},
         {"text", "it may still run cell " + other.status.cell().to_string() +
                      ", which is undeployed on the other devices; they tell it when it is back"}});
  }
  if (!deployment_) return list;
  for (const model::Device& device : deployment_->cell.devices) {
    if (device.name == options_.device) continue;
    const auto seen = others_.devices(device.name);
    if (std::any_of(seen.begin(), seen.end(), [](const wire::ObservedDevice& s) { return s.alive; }))
      continue;
    json modules = json::array();
    for (const model::Module& module : device.modules) {
      std::string state = "UNKNOWN";
      for (const wire::ObservedDevice& s : seen) {
        const auto status = s.deployment.modules.find(module.name);
        if (status != s.deployment.modules.end()) state = takt::to_text(status->second.state());
      }
      modules.push_back({{"name", module.name},
                         {"type", model::to_text(module.type)},
                         {"operation", model::to_text(module.operation)},
                         {"state", state}});
    }
    list.push_back({{"name", device.name}, {"modules", modules}});
    if (const std::string why = options_.rejection_of(device.name); !why.empty()) list.back()["text"] = why;
  }
  return list;
}

void Agent::descriptor(const Command& command) {
  if (!deployment_) {
    answer(command, REPLY_REFUSED, "device " + options_.device + " has no deployment");
    return;
  }
  answer(command, REPLY_OK, "", deployment_->text, {}, deployment_->file);
}

void Agent::describe(const Command& command) {
  if (!deployment_ || !deployment_->supervised) {
    answer(command, REPLY_REFUSED, "device " + options_.device + " has no deployment to describe");
    return;
  }
  Deployment& d = *deployment_;
  if (!d.description.empty()) {
    answer(command, REPLY_OK, "", d.description);
    return;
  }
  d.describers.push_back(command);
  if (d.describing) return;
  auto inspection = factories_.inspect({.text = d.text,
                                        .file = d.file,
                                        .device = options_.device,
                                        .as_written = options_.temporary,
                                        .describe = true,
                                        .swapped = d.swapped});
  if (inspection)
    d.describing = std::move(*inspection);
  else
    described(inspection.problems());
}

void Agent::check_description() {
  if (!deployment_ || !deployment_->describing) return;
  if (const auto result = deployment_->describing->result(); result) {
    deployment_->describing.reset();
    described(*result);
  }
}

void Agent::described(const Result<Inspected>& result) {
  Deployment& d = *deployment_;
  if (result) d.description = result->description;
  for (const Command& describer : std::exchange(d.describers, {})) {
    if (result)
      answer(describer, REPLY_OK, "", d.description);
    else
      answer(describer, REPLY_FAILED, in_words(result.problems()),
             model::json_text(problems_json(result.problems())));
  }
}

/// A command to every module of the device. The agent answers the command when all modules have answered.
struct Agent::WholeDevice {
  Command command;
  json outcomes = json::array();
  std::size_t open = 0;
  std::size_t done = 0;
  std::size_t refused = 0;
  std::string why;  ///< the reason why the first failed module failed
};

bool Agent::runs(const Command& command) {
  if (deployment_ && deployment_->supervised && deployment_->supervised->phase() == Phase::running)
    return true;
  answer(
      command, REPLY_REFUSED,
      deployment_
          ? "device " + options_.device + " is not running: its state is " + takt::to_text(published_.state())
      : resuming_
          ? "device " + options_.device + " is about to restore its deployment; try again when it is running"
          : "device " + options_.device + " has no deployment; deploy a cell to it first: takt deploy CELL");
  return false;
}

std::optional<std::uint32_t> Agent::module_of(const Command& command) {
  const std::vector<model::Module>& modules = deployment_->of_device().modules;
  const std::string name = command.module_name().to_string();
  const auto module =
      std::find_if(modules.begin(), modules.end(), [&](const model::Module& m) { return m.name == name; });
  if (module != modules.end()) return static_cast<std::uint32_t>(module - modules.begin());
  std::vector<std::string_view> names;
  for (const model::Module& m : modules) names.push_back(m.name);
  answer(command, REPLY_REFUSED,
         "device " + options_.device + " has no module " + in_quotes(name) + "; " + suggestion(name, names));
  return std::nullopt;
}

void Agent::property(const Command& command) {
  if (!runs(command)) return;
  const auto module = module_of(command);
  if (!module) return;
  const auto done = [this, command](const Outcome& outcome) { answer_outcome(command, outcome); };
  const std::string name = command.property().to_string();
  if (command.kind() == COMMAND_GET) {
    deployment_->supervised->get(*module, name, done);
  } else {
    const auto set = [this, command, name, done](const Outcome& outcome) {
      const std::string value = command.value().to_string();
      if (outcome.code == REPLY_OK && deployment_)
        deployment_->set[command.module_name().to_string()][name] = value;
      done(outcome);
    };
    deployment_->supervised->set(*module, name, command.value().to_string(), set);
  }
}

void Agent::tap(const Command& command) {
  if (!runs(command)) return;
  const auto module = module_of(command);
  if (!module) return;
  // The requested end of the tap may be wrong, because the clock of the requesting machine may differ. So the
  // tap stays open for at most kLongestTap.
  const Nanoseconds asked = span(options_.wall_ns(), command.time_ns());
  const Nanoseconds longer = asked > Nanoseconds{0} ? std::min(asked, kLongestTap) : kLongestTap;
  const std::string value = command.value().to_string();
  std::int64_t every_ns = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), every_ns);
  if (!value.empty() && (error != std::errc{} || end != value.data() + value.size() || every_ns < 0)) {
    answer(command, REPLY_REFUSED, in_quotes(value) + " is not a number of nanoseconds");
    return;
  }
  const auto tapped =
      deployment_->supervised->tap(*module, command.property().to_string(), options_.now() + longer,
                                   std::min(Nanoseconds{every_ns}, kLongestTap));
  if (!tapped) {
    answer(command, REPLY_REFUSED, in_words(tapped.problems()));
    return;
  }
  nlohmann::ordered_json data{
      {"topic", tapped->topic}, {"type", tapped->type}, {"reliable", tapped->reliable}};
  if (!tapped->reply_topic.empty())
    data["reply"] = {{"topic", tapped->reply_topic}, {"type", tapped->reply_type}};
  answer(command, REPLY_OK, "", model::json_text(data));
}

void Agent::force(const wire::WholeCommand& command) {
  const Command& head = command.head;
  if (!runs(head)) return;
  const auto module = module_of(head);
  if (!module) return;
  const Nanoseconds duration{head.time_ns()};
  if (!command.data.empty() && (duration <= Nanoseconds{0} || duration > kLongestForce)) {
    return answer(head, REPLY_REFUSED,
                  "an input can be forced for at most " + takt::to_text(kLongestForce) + ", but not for " +
                      takt::to_text(duration));
  }
  const auto value = deployment_->supervised->force(*module, {.port = head.property().to_string(),
                                                              .data = command.data,
                                                              .client = client_of(head),
                                                              .by = sender_of(command),
                                                              .duration = duration});
  if (value)
    answer(head, REPLY_OK, "", *value);
  else
    reply_problems(head, REPLY_REFUSED, value.problems());
}

void Agent::end_force(const wire::WholeCommand& command) {
  const Command& head = command.head;
  if (!runs(head)) return;
  const auto module = module_of(head);
  if (!module) return;
  const auto ended =
      deployment_->supervised->end_force(*module, head.property().to_string(), sender_of(command));
  if (ended)
    answer(head, REPLY_OK, "");
  else
    reply_problems(head, REPLY_REFUSED, ended.problems());
}

void Agent::trace(const Command& command) {
  if (!deployment_ || !deployment_->supervised) {
    answer(command, REPLY_REFUSED, "device " + options_.device + " has no deployment to trace");
    return;
  }
  const std::string value = command.value().to_string();
  std::int64_t ns = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), ns);
  if (error != std::errc{} || end != value.data() + value.size() || ns <= 0) {
    answer(command, REPLY_REFUSED, in_quotes(value) + " is not a number of nanoseconds above 0");
    return;
  }
  deployment_->supervised->trace(Nanoseconds{ns}, wire::kMaxData,
                                 [this, command](const Result<std::string>& trace) {
                                   if (trace)
                                     answer(command, REPLY_OK, "", *trace);
                                   else
                                     answer(command, REPLY_FAILED, in_words(trace.problems()));
                                 });
}

void Agent::swap(const Command& command) {
  if (!runs(command)) return;
  const auto module = module_of(command);
  if (!module) return;
  Deployment& d = *deployment_;
  if (update_) {
    answer(command, REPLY_REFUSED, "device " + options_.device + " is being updated; try again later");
    return;
  }
  if (d.swap) {
    answer(command, REPLY_REFUSED,
           "device " + options_.device + " is still swapping " + d.swap->module_name().to_string() +
               "; try again later");
    return;
  }
  if (const auto may = d.supervised->may_swap(*module); !may) {
    answer(command, REPLY_REFUSED, in_words(may.problems()));
    return;
  }
  const std::string name = command.module_name().to_string();
  const std::string file = command.value().to_string();
  if (const std::size_t slash = file.rfind('/'); slash != std::string::npos && !options_.temporary) {
    const std::string target = options_.device + "." + name;
    reply_problems(command, REPLY_REFUSED,
                   {{"file " + file,
                     "it has a path, but device " + options_.device +
                         " searches its component path for the file name only",
                     "copy the file there, then run takt swap " + target + " " + file.substr(slash + 1)}});
    return;
  }
  auto swap_inspection = factories_.inspect({.text = d.text,
                                             .file = d.file,
                                             .device = options_.device,
                                             .as_written = options_.temporary,
                                             .only = name,
                                             .swapped = {{name, file}}});
  if (!swap_inspection) {
    answer(command, REPLY_FAILED, in_words(swap_inspection.problems()));
    return;
  }
  d.swap = command;
  d.swap_inspection = std::move(*swap_inspection);
}

void Agent::check_swap() {
  if (!deployment_ || !deployment_->swap_inspection) return;
  Deployment& d = *deployment_;
  const auto result = d.swap_inspection->result();
  if (!result) return;
  d.swap_inspection.reset();
  const auto module = module_of(*d.swap);
  if (!*result) {
    const Command command = *std::exchange(d.swap, std::nullopt);
    Problems problems = result->problems();
    // The operator gave the file on the command line. So the problems name this file instead of the module's
    // line in the descriptor.
    for (Problem& problem : problems) problem.where = "file " + command.value().to_string();
    reply_problems(command, REPLY_REFUSED, problems);
    return;
  }
  const std::string path = (*result)->paths.at(0);
  const model::Build build = (*result)->builds.empty() ? model::Build{} : (*result)->builds[0];
  d.supervised->swap(*module, path, {}, [this, path, build, index = *module](const Outcome& outcome) {
    Deployment& swapped = *deployment_;
    const Command command = *std::exchange(swapped.swap, std::nullopt);
    if (outcome.code == REPLY_OK) {
      swapped.swapped[command.module_name().to_string()] = path;
      swapped.found.paths.at(index) = path;
      if (index < swapped.found.builds.size()) swapped.found.builds[index] = build;
      swapped.description.clear();
    }
    Outcome with_path = outcome;
    with_path.value = outcome.code == REPLY_OK ? path : "";
    answer_outcome(command, with_path);
  });
}

void Agent::command_module(const Command& command, Verb verb) {
  if (!runs(command)) return;
  const std::vector<model::Module>& modules = deployment_->of_device().modules;
  if (command.module_name().size() != 0) {
    const auto module = module_of(command);
    if (!module) return;
    deployment_->supervised->command(
        *module, verb, [this, command](const Outcome& outcome) { answer_outcome(command, outcome); });
    return;
  }
  auto all = std::make_shared<WholeDevice>();
  all->command = command;
  all->open = modules.size();
  for (std::uint32_t i = 0; i < modules.size(); ++i) {
    deployment_->supervised->command(i, verb, [this, all, module = modules[i].name](const Outcome& outcome) {
      all->done += outcome.code == REPLY_OK ? 1 : 0;
      all->refused += outcome.code == REPLY_REFUSED ? 1 : 0;
      if (outcome.code != REPLY_OK && all->why.empty()) all->why = module + ": " + outcome.text;
      all->outcomes.push_back({{"module", module},
                               {"ok", outcome.code == REPLY_OK},
                               {"state", lifecycle::to_text(outcome.state)},
                               {"text", outcome.text}});
      if (--all->open != 0) return;
      const std::size_t count = all->outcomes.size();
      const ReplyCode code = all->done == count      ? REPLY_OK
                             : all->refused == count ? REPLY_REFUSED
                                                     : REPLY_FAILED;
      answer(all->command, code,
             code == REPLY_OK ? ""
                              : std::to_string(count - all->done) + " of " + std::to_string(count) +
                                    " modules failed: " + all->why,
             model::json_text(all->outcomes));
    });
  }
}

}  // namespace takt::agent
