#include <takt/client/operator.hpp>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <cstdio>
#include <map>
#include <mutex>
#include <random>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/client/identity.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/model/validate.hpp>
#include <takt/wire/question.hpp>
#include <takt/wire/validation.hpp>
#include <takt/wire/words.hpp>
#include "answers.hpp"
#include "reports.hpp"

namespace takt::client {

namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;
using json = nlohmann::ordered_json;

/// The deadline of a command whose request has no time limit: the node must begin to execute the command
/// within this time.
constexpr std::chrono::seconds kBegun{10};
/// The longest time of the search for a node, without and with DDS Security.
constexpr Nanoseconds kSearch = std::chrono::seconds{3};
constexpr Nanoseconds kSecuredSearch = std::chrono::seconds{10};
/// The name of a node's participant begins with this.
const std::string kNode = "takt-node ";
/// A search over a slow link looks again after this time whether packets still arrive.
constexpr Nanoseconds kLook = milliseconds{100};
/// If a node is lost before it answers a command, send() waits this long for the node to come back, because
/// the machine may only have been busy. Then the command fails, unless other packets arrive from the node.
constexpr Nanoseconds kBack = milliseconds{700};

/// Returns the duration in whole seconds, for a message.
Nanoseconds rounded(Nanoseconds duration) { return std::chrono::floor<std::chrono::seconds>(duration); }

std::string device_of(const CommandRequest& request) { return "device " + request.device; }

/// The sizes of the names and of the value in takt::Command.
constexpr std::size_t kLongestName = 63;
constexpr std::size_t kLongestValue = 255;

/// Returns the problem `what` of a device that has not answered, with what was tried: how often the command
/// was sent, and when the last status of the device arrived. Each device sends its status ten times a second.
Problem no_answer(const CommandRequest& request, const std::string& what, int sent, Nanoseconds silent) {
  return {device_of(request),
          what + "; the command was sent " + std::to_string(sent) + (sent == 1 ? " time" : " times") +
              ", and the last status of the device arrived " + takt::to_text(silent) + " ago",
          sent == 0 || wire::is_question(request.kind) || request.kind == COMMAND_PREPARE
              ? "check the network, and try again"
              : "the device may have carried it out: check with takt status before you try again"};
}

}  // namespace

Result<void> check(const CommandRequest& request) {
  // A node would drop a request with an invalid name without an answer, or would read a longer name as
  // another name. A longer value would be cut.
  for (const std::string* name : {&request.device, &request.module, &request.property}) {
    if (name->size() <= kLongestName && wire::is_name(*name)) continue;
    return fail(in_quotes(*name) + " is not a valid name",
                "a name has at most " + std::to_string(kLongestName) + " bytes, and no control characters");
  }
  if (request.value.size() > kLongestValue) {
    return fail(
        "the value " + in_quotes(request.value) + " has " + std::to_string(request.value.size()) + " bytes",
        "give a value of at most " + std::to_string(kLongestValue) + " bytes");
  }
  return {};
}

struct Operator::Inside {
  std::mutex mutex;
  std::condition_variable answered;
  std::map<std::string, std::optional<wire::WholeReply>> open;  // by command id; empty: no answer yet
  std::uint64_t asked = 0;
  std::string name;  // the first part of every command id, unique to this program
  std::shared_ptr<dds::Participant> participant;
  std::optional<dds::CommandClient> client;
  std::function<void(const std::string&)> progress;
  std::mutex progress_mutex;
  std::string told;  // the devices that the last call of `progress` has named

  void receive(const wire::WholeReply& reply) {
    {
      const std::lock_guard lock{mutex};
      const auto found = open.find(reply.head.id().to_string());
      if (found == open.end() || found->second) return;
      found->second = reply;
    }
    answered.notify_all();
  }
};

Operator::Operator(std::unique_ptr<Inside> inside, const Observer& observer, int domain,
                   std::string node_options, Nanoseconds search_limit)
    : inside_(std::move(inside)),
      observer_(observer),
      domain_(domain),
      node_options_(std::move(node_options)),
      search_limit_(search_limit) {}

Operator::~Operator() = default;

Result<std::unique_ptr<Operator>> Operator::create(std::shared_ptr<dds::Participant> participant,
                                                   const Observer& observer, int domain,
                                                   std::string node_options,
                                                   std::function<void(const std::string&)> progress) {
  auto inside = std::make_unique<Inside>();
  Inside* const me = inside.get();
  std::random_device random;
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%08x%08x", random(), random());
  inside->name = digits.data();
  const Nanoseconds search_limit = participant->identity() ? kSecuredSearch : kSearch;
  inside->participant = participant;
  inside->progress = std::move(progress);
  auto client = dds::CommandClient::create(std::move(participant),
                                           [me](const wire::WholeReply& reply) { me->receive(reply); });
  if (!client) return client.problems();
  inside->client.emplace(std::move(*client));
  return std::unique_ptr<Operator>{
      new Operator{std::move(inside), observer, domain, std::move(node_options), search_limit}};
}

Result<wire::WholeReply> Operator::send(const CommandRequest& request) {
  return std::move(send(std::vector{request})[0]);
}

std::vector<Result<wire::WholeReply>> Operator::send(const std::vector<CommandRequest>& requests,
                                                     const std::function<bool()>& give_up) {
  // Each request passes through three stages: find the node, send the command, receive the answer.
  struct State {
    std::string id;
    std::string node;
    std::optional<Clock::time_point> sent;
    std::uint64_t last_status = 0;  // the sequence number of the node's last status, which arrived at `heard`
    Clock::time_point heard;
    std::optional<Clock::time_point> gone_since;
    std::optional<Result<wire::WholeReply>> outcome;
  };
  std::vector<State> states(requests.size());
  const auto begun = Clock::now();
  for (std::size_t i = 0; i < requests.size(); ++i) {
    if (const auto valid = check(requests[i]); !valid) states[i].outcome = valid.problems();
  }
  if (const auto valid = check_identity(*inside_->participant); !valid) {
    for (State& state : states) state.outcome = valid.problems();
  }
  {
    const std::lock_guard lock{inside_->mutex};
    for (State& state : states) {
      state.id = inside_->name + "-" + std::to_string(++inside_->asked);
      inside_->open[state.id];
    }
  }

  const auto meant = [](const CommandRequest& q, const wire::ObservedDevice& seen) {
    return (q.process_id == 0 || seen.status.process_id() == q.process_id) &&
           (q.node.empty() || seen.node() == q.node);
  };
  const auto advance = [&](const CommandRequest& q, State& state) {
    const Nanoseconds find_within = std::min(q.limit.value_or(search_limit_), search_limit_);
    std::vector<wire::ObservedDevice> alive;
    bool is_lost = false;
    for (const wire::ObservedDevice& seen : observer_.devices(q.device)) {
      if (!meant(q, seen)) continue;
      if (seen.alive)
        alive.push_back(seen);
      else
        is_lost = true;
    }
    if (state.sent) {
      const auto seen = std::find_if(alive.begin(), alive.end(), [&](const wire::ObservedDevice& one) {
        return one.node() == state.node;
      });
      const bool there = seen != alive.end();
      if (there && seen->status.sequence_number() != state.last_status) {
        state.last_status = seen->status.sequence_number();
        state.heard = Clock::now();
      }
      if (there) {
        state.gone_since.reset();
      } else if (!state.gone_since) {
        state.gone_since = Clock::now();
      }
      if (inside_->client->is_too_late(state.id)) {
        state.outcome = Problem{device_of(q),
                                std::string{"command "} + to_text(q.kind) + " could not be sent within " +
                                    takt::to_text(q.limit.value_or(kBegun)),
                                "the device did not get it; try again"};
        return;
      }
      const auto now = Clock::now();
      const Nanoseconds limit = q.limit.value_or(kLongestCommand);
      if (const std::string obstacle = inside_->participant->obstacle(q.device); !obstacle.empty()) {
        state.outcome =
            Problem{device_of(q), std::string{"no answer to command "} + to_text(q.kind) + ": " + obstacle,
                    "every network and VPN on the path must pass IP packets of 1280 bytes"};
        return;
      }
      std::string what;
      if (!there && now - *state.gone_since > kBack && !sends(q.device))
        what = std::string{"it was lost before it answered command "} + to_text(q.kind);
      else if (now - *state.sent > limit)
        what = std::string{"no answer to command "} + to_text(q.kind) + " within " + takt::to_text(limit);
      else
        return;
      state.outcome = no_answer(q, what, inside_->client->sent(state.id),
                                std::chrono::duration_cast<milliseconds>(now - state.heard));
      return;
    }
    if (alive.size() > 1) {
      std::vector<DeviceStatus> nodes;
      for (const wire::ObservedDevice& seen : alive) nodes.push_back(seen.status);
      state.outcome =
          Problem{device_of(q), wire::nodes_of_one_name(nodes, domain_), "end all but one of them"};
      return;
    }
    if (alive.empty()) {
      const auto since = Clock::now() - begun;
      if (since <= find_within) return;
      if (since <= std::min(q.limit.value_or(kSlowestSearch), kSlowestSearch) &&
          !matching({q.device}).empty())
        return;
      state.outcome = is_lost ? lost(q.device) : not_found(q.device, std::max(find_within, rounded(since)));
      return;
    }
    state.sent = state.heard = Clock::now();
    state.node = alive[0].node();
    state.last_status = alive[0].status.sequence_number();
    wire::WholeCommand command;
    command.head.id(state.id);
    wire::set(command.head.device(), q.device);
    wire::set(command.head.node(), state.node);
    wire::set(command.head.module_name(), q.module);
    command.head.kind(q.kind);
    wire::set(command.head.deployment(), q.deployment);
    wire::set(command.head.property(), q.property);
    wire::set(command.head.value(), q.value);
    command.head.time_ns(q.time_ns);
    command.head.deadline_ns(wall_ns() + q.limit.value_or(kBegun).count());
    command.data = q.data;
    inside_->client->send(command);
  };

  const auto open = [&states] {
    return std::any_of(states.begin(), states.end(), [](const State& state) { return !state.outcome; });
  };
  while (open()) {
    for (std::size_t i = 0; i < states.size(); ++i) {
      if (!states[i].outcome) advance(requests[i], states[i]);
    }
    const bool enough = give_up && give_up();
    std::unique_lock lock{inside_->mutex};
    const auto take = [&] {
      bool taken = false;
      for (State& state : states) {
        auto& reply = inside_->open.at(state.id);
        if (!reply) continue;
        state.outcome = std::move(*reply);  // a reply that has arrived counts, even if give_up() has returned
                                            // true
        reply.reset();
        taken = true;
      }
      return taken;
    };
    if (take()) continue;
    for (std::size_t i = 0; enough && i < states.size(); ++i) {
      if (!states[i].outcome)
        states[i].outcome = Problem{device_of(requests[i]), "no answer before the wait was cancelled", ""};
    }
    if (open()) inside_->answered.wait_for(lock, milliseconds{10});
  }

  std::vector<Result<wire::WholeReply>> outcomes;
  outcomes.reserve(states.size());
  const std::lock_guard lock{inside_->mutex};
  for (State& state : states) {
    inside_->open.erase(state.id);
    inside_->client->forget(state.id);
    outcomes.push_back(std::move(*state.outcome));
  }
  return outcomes;
}

Problem Operator::lost(const std::string& device, std::string why) const {
  if (why.empty()) why = inside_->participant->rejection_of(device);
  if (!why.empty()) return {"device " + device, "it is lost: " + why, ""};
  return {"device " + device, "it is lost: its node no longer answers",
          std::string{wire::kLostRemedy} + "; takt log --kind device-lost shows since when it is lost"};
}

std::string Operator::unresolved() const { return inside_->participant->unresolved(); }

bool Operator::search(const std::function<bool(const std::vector<wire::ObservedDevice>&)>& condition,
                      Nanoseconds limit, const std::set<std::string>& wanted) const {
  const auto end = Clock::now() + kSlowestSearch;
  bool found = observer_.wait(condition, limit);
  while (!found && Clock::now() < end) {
    const std::string names = matching(wanted);
    if (names.empty()) break;
    {
      const std::lock_guard lock{inside_->progress_mutex};
      if (std::exchange(inside_->told, names) != names && inside_->progress)
        inside_->progress("waiting for the status of " + names + ", whose packets arrive slowly");
    }
    found = observer_.wait(condition, kLook);
  }
  return found;
}

std::string Operator::matching(const std::set<std::string>& wanted) const {
  std::string names;
  for (const auto& [name, sends_more] : silent()) {
    if (sends_more && (wanted.empty() || wanted.contains(name))) names += (names.empty() ? "" : ", ") + name;
  }
  return names;
}

bool Operator::sends(const std::string& device) const {
  const auto announced = inside_->participant->announced();
  return std::ranges::any_of(
      announced, [&device](const auto& one) { return one.sends_more && one.name == kNode + device; });
}

std::map<std::string, bool> Operator::silent() const {
  std::map<std::string, bool> devices;
  for (const auto& [name, sends_more] : inside_->participant->announced()) {
    const std::string device = name.starts_with(kNode) ? name.substr(kNode.size()) : std::string{};
    if (model::is_valid_name(device) && observer_.devices(device).empty()) devices[device] |= sends_more;
  }
  return devices;
}

std::string Operator::remedy_of_silence(const std::map<std::string, bool>& devices) {
  std::string only_announced;
  std::string others;
  for (const auto& [name, sends_more] : devices) {
    std::string& list = sends_more ? others : only_announced;
    list += (list.empty() ? "" : ", ") + name;
  }
  std::string text;
  if (!only_announced.empty())
    text = "only announcements arrived from " + only_announced +
           ": check whether the network loses or delays packets, and whether both sides use DDS Security";
  if (!others.empty())
    text += (text.empty() ? "" : "; ") + std::string{"discovery messages, but no status, arrived from "} +
            others + ": the network is slow or loses packets; try again";
  return text;
}

std::string Operator::remedy_of_silence(const std::string& device) const {
  auto devices = silent();
  std::erase_if(devices, [&device](const auto& each) { return each.first != device; });
  return remedy_of_silence(devices);
}

Problem Operator::not_found(const std::string& device, Nanoseconds within) const {
  const std::string remedy = remedy_of_silence(device);
  return {
      "device " + device, "not found: no answer within " + takt::to_text(within),
      !remedy.empty() ? remedy : "check that " + node_command(device) + " is running; " + found_there(*this)};
}

Problems problems_of(const wire::WholeReply& reply) {
  Problems problems;
  const json list = model::parse_json(reply.data);
  if (list.is_array()) {
    for (const json& entry : list) {
      if (!entry.is_object() || !entry.contains("what")) continue;
      const auto text = [&entry](const char* name) {
        return entry.contains(name) && entry[name].is_string() ? entry[name].get<std::string>() : "";
      };
      problems.push_back({text("where"), text("what"), text("fix")});
    }
  }
  if (problems.empty()) {
    const std::string text = reply.head.text().to_string();
    problems.push_back({"device " + reply.head.device().to_string(),
                        text.empty() ? "its answer reports an error without a reason" : text, ""});
  }
  return problems;
}

Result<wire::WholeReply> accepted(Result<wire::WholeReply> answer) {
  if (!answer || answer->head.code() == REPLY_OK) return answer;
  return problems_of(*answer);
}

}  // namespace takt::client
