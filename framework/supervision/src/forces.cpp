#include "forces.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include <takt/core/words.hpp>
#include <takt/model/field_values.hpp>
#include <takt/model/json.hpp>
#include <takt/wire/words.hpp>
#include "limits.hpp"
#include "member.hpp"

namespace takt::supervision {

namespace {

/// Converts the data of a request, an object or an array of texts FIELD=VALUE, to a sample.
Result<std::vector<std::byte>> sample_of(const model::Type& type, const std::string& data) {
  std::vector<std::string> words{data};
  if (data.starts_with('[')) {
    const auto list = nlohmann::ordered_json::parse(data, nullptr, false);
    if (!list.is_array() ||
        !std::all_of(list.begin(), list.end(), [](const auto& e) { return e.is_string(); }))
      return fail("the value is not a list of texts FIELD=VALUE");
    words = list.get<std::vector<std::string>>();
  }
  const auto json = model::json_of_input(type, words);
  if (!json) return json.problems();
  return model::sample_bytes(type, *json);
}

}  // namespace

std::string Forces::path(const Member& member, const std::string& port) const {
  return parts_.of_device().name + "." + member.model.name + "." + port;
}

Result<const model::Port*> Forces::input(const Member& member, const std::string& name) const {
  const model::ModulePorts& ports = parts_.ports.at(member.index);
  const std::string module = "module " + parts_.of_device().name + "." + member.model.name;
  if (!ports)
    return fail("the ports of " + module + " are not known", "connect one of them in the descriptor");
  std::vector<std::string_view> inputs;
  for (const model::Port& port : *ports) {
    if (port.name == name) return &port;
    if (port.direction == model::Direction::in && port.role == model::Role::plain)
      inputs.push_back(port.name);
  }
  return fail(module + " has no port " + in_quotes(name),
              inputs.empty() ? "it has no inputs" : suggestion(name, inputs));
}

Result<channel::Link> Forces::link_of(const Member& member, const model::Port& port) const {
  const std::string name = path(member, port.name);
  if (port.role != model::Role::plain) return fail(name + " belongs to a service and cannot be forced");
  if (port.direction == model::Direction::out) {
    std::string inputs;
    for (const model::Connection& connection : parts_.cell.connections) {
      if (connection.to.given() && model::to_text(connection.from) == name)
        inputs += (inputs.empty() ? "" : ", ") + model::to_text(connection.to);
    }
    return fail(
        name + " is an output; only inputs can be forced",
        inputs.empty() ? "no input is connected to it" : "force an input that it is connected to: " + inputs);
  }
  if (port.direction == model::Direction::event)
    return fail(name + " is an event port and cannot be forced",
                "only inputs that hold the latest value can be forced");
  const Wiring::CreatedLink* found = nullptr;
  for (const Wiring::CreatedLink& created : parts_.wiring.links()) {
    if (created.plan.to == LinkEnd{member.index, port.name}) found = &created;
  }
  if (found == nullptr)
    return fail("input " + name + " has no connection and cannot be forced", "connect it in the descriptor");
  if (found->plan.options.is_queue)
    return fail("input " + name + " is a queue and cannot be forced",
                "only inputs that hold the latest value can be forced");
  if (!found->link.has_force_place())
    return fail("a value of input " + name + " can have " + std::to_string(model::max_size(port.type)) +
                " bytes; only inputs of up to " + std::to_string(kMostForced) + " bytes can be forced");
  return found->link;
}

Result<std::string> Forces::force(const Member& member, const ForceRequest& request, Instant now) {
  return request.data.empty() ? renew(member, request, now) : begin(member, request, now);
}

Result<std::string> Forces::begin(const Member& member, const ForceRequest& request, Instant now) {
  const auto port = input(member, request.port);
  if (!port) return port.problems();
  const auto link = link_of(member, **port);
  if (!link) return link.problems();
  const std::string name = path(member, request.port);
  const std::string module = parts_.of_device().name + "." + member.model.name;
  if (member.state() != lifecycle::State::executing)
    return fail("module " + module + " is in " + lifecycle::to_text(member.state()) +
                    "; its inputs can be forced only in EXECUTING",
                "run takt start " + module);
  if (member.command)
    return fail(std::string{name_of(member.command->verb)} + " is still in progress", "try again later");
  if (member.swap) return fail("a swap of " + module + " is still in progress", "try again later");
  const Key key{member.index, request.port};
  if (const auto other = forces_.find(key); other != forces_.end())
    return fail("input " + name + " is forced already, by " + other->second.by + ", to " + other->second.json,
                "end that force first: takt force --end " + name);
  const auto bytes = sample_of((*port)->type, request.data);
  if (!bytes) return bytes.problems();

  Force force{.link = *link,
              .json = model::sample_json((*port)->type, bytes->data(), bytes->size()),
              .client = request.client,
              .by = request.by,
              .until = now + request.duration,
              .renewed = now,
              .entered = member.block.entered.load(std::memory_order_relaxed)};
  if (++last_ == 0) ++last_;
  if (!link->force(last_, *bytes, to_ns(std::min(force.until, now + kForceLease))))
    return fail("module " + module + " is just reading the value of the last force", "try again");
  const std::string cause = "input '" + request.port + "' is forced to " + wire::cut(force.json, 200) +
                            " for at most " + to_text(request.duration) + ", by " + force.by;
  notes_.note(member, model::FaultKind::forced, cause);
  log_(member, cause);
  std::string json = force.json;
  ended_.erase(key);
  forces_.emplace(key, std::move(force));
  return json;
}

Result<std::string> Forces::renew(const Member& member, const ForceRequest& request, Instant now) {
  const Key key{member.index, request.port};
  const auto at = forces_.find(key);
  if (at != forces_.end() && at->second.client == request.client) {
    Force& force = at->second;
    force.renewed = now;
    force.link.renew_force(to_ns(std::min(force.until, now + kForceLease)));
    return std::string{};
  }
  const auto ended = ended_.find(key);
  return fail(
      "input " + path(member, request.port) + " is no longer forced" +
      (ended != ended_.end() && ended->second.client == request.client ? ": " + ended->second.why : ""));
}

Result<void> Forces::end(const Member& member, const std::string& port, const std::string& who) {
  if (const auto known = input(member, port); !known) return known.problems();
  const auto at = forces_.find({member.index, port});
  if (at == forces_.end())
    return fail("input " + path(member, port) + " is not forced", "list the forced inputs with takt force");
  drop(at, who + " ended it");
  return {};
}

void Forces::drop(std::map<Key, Force>::iterator at, const std::string& why) {
  const Member& member = *members_.at(at->first.first);
  const Force& force = at->second;
  force.link.end_force();
  const std::string cause = "input '" + at->first.second + "' is no longer forced to " +
                            wire::cut(force.json, 200) + " by " + force.by + ": " + why;
  notes_.note(member, model::FaultKind::force_ended, cause);
  log_(member, cause);
  ended_[at->first] = {force.client, why};
  forces_.erase(at);
}

void Forces::end_all(const Member& member, const std::string& why) {
  for (auto at = forces_.begin(); at != forces_.end();) {
    const auto next = std::next(at);
    if (at->first.first == member.index) drop(at, why);
    at = next;
  }
}

void Forces::check(Instant now) {
  for (auto at = forces_.begin(); at != forces_.end();) {
    const auto next = std::next(at);
    const Member& member = *members_.at(at->first.first);
    const Force& force = at->second;
    if (member.state() != lifecycle::State::executing ||
        member.block.entered.load(std::memory_order_relaxed) != force.entered) {
      drop(at, "the module does not execute any more");
    } else if (now >= force.until) {
      drop(at, "its time is over");
    } else if (now >= force.renewed + kForceLease) {
      drop(at, "its client has not renewed it for " + to_text(kForceLease));
    }
    at = next;
  }
}

std::string Forces::by(const Member& member, const std::string& port) const {
  const auto at = forces_.find({member.index, port});
  return at == forces_.end() ? "" : at->second.by;
}

nlohmann::ordered_json Forces::report(const Member& member, const std::string& port, Instant now) const {
  const auto at = forces_.find({member.index, port});
  if (at == forces_.end()) return nullptr;
  const Force& force = at->second;
  return {{"by", force.by},
          {"value", model::parse_json(force.json)},
          {"left_s", std::chrono::duration<double>(force.until - now).count()}};
}

}  // namespace takt::supervision
