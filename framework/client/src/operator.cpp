#include <takt/client/operator.hpp>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <cstdio>
#include <map>
#include <mutex>
#include <random>

#include <nlohmann/json.hpp>

#include <takt/wire/words.hpp>
#include <takt/model/json.hpp>
#include "answers.hpp"

namespace takt::client {

namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;
using json = nlohmann::ordered_json;

/// If the question has no time limit, the node must begin to execute the command within this time.
constexpr std::chrono::seconds kBegun{10};
/// How long to search for a node, without and with DDS Security.
constexpr Nanoseconds kSearch = std::chrono::seconds{3};
constexpr Nanoseconds kSecuredSearch = std::chrono::seconds{10};
/// A node that is lost while a command waits for its answer may come back within this time, because perhaps
/// its machine was only busy. After this time, the command fails.
constexpr Nanoseconds kBack = milliseconds{700};

std::string device_of(const Question& question) { return "device " + question.device; }

}  // namespace

struct Operator::Inside {
  std::mutex mutex;
  std::condition_variable answered;
  std::map<std::string, std::optional<wire::WholeReply>> open;  // answers received so far, by command id
  std::uint64_t asked = 0;
  std::string name;  // the first part of every command id, unique to this program
  std::optional<dds::CommandClient> client;

  void heard(const wire::WholeReply& reply) {
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
                   Nanoseconds search_limit)
    : inside_(std::move(inside)), observer_(observer), domain_(domain), search_limit_(search_limit) {}

Operator::~Operator() = default;

Result<std::unique_ptr<Operator>> Operator::create(std::shared_ptr<dds::Participant> participant,
                                                   const Observer& observer, int domain) {
  auto inside = std::make_unique<Inside>();
  Inside* const place = inside.get();
  std::random_device random;
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%08x%08x", random(), random());
  inside->name = digits.data();
  const Nanoseconds search_limit = participant->identity() ? kSecuredSearch : kSearch;
  auto client = dds::CommandClient::create(std::move(participant),
                                           [place](const wire::WholeReply& reply) { place->heard(reply); });
  if (!client) return client.problems();
  inside->client.emplace(std::move(*client));
  return std::unique_ptr<Operator>{new Operator{std::move(inside), observer, domain, search_limit}};
}

Result<wire::WholeReply> Operator::ask(const Question& question) {
  return std::move(ask(std::vector{question})[0]);
}

std::vector<Result<wire::WholeReply>> Operator::ask(const std::vector<Question>& questions,
                                                   const std::function<bool()>& give_up) {
  // Each question passes through three stages: find the node, send the command, receive the answer.
  struct State {
    std::string id;
    std::string node;
    std::optional<Clock::time_point> sent;
    std::optional<Clock::time_point> gone_since;
    std::optional<Result<wire::WholeReply>> outcome;
  };
  std::vector<State> states(questions.size());
  const auto begun = Clock::now();
  {
    const std::lock_guard lock{inside_->mutex};
    for (State& state : states) {
      state.id = inside_->name + "-" + std::to_string(++inside_->asked);
      inside_->open[state.id];
    }
  }

  const auto meant = [](const Question& q, const wire::ObservedDevice& seen) {
    return q.process_id == 0 || seen.status.process_id() == q.process_id;
  };
  const auto advance = [&](const Question& q, State& state) {
    const Nanoseconds find_within = std::min(q.limit.value_or(search_limit_), search_limit_);
    std::vector<wire::ObservedDevice> alive;
    bool lost = false;
    for (const wire::ObservedDevice& seen : observer_.devices(q.device)) {
      if (!meant(q, seen)) continue;
      if (seen.alive)
        alive.push_back(seen);
      else
        lost = true;
    }
    if (state.sent) {
      const bool there = std::any_of(alive.begin(), alive.end(), [&](const wire::ObservedDevice& seen) {
        return seen.node() == state.node;
      });
      if (there) {
        state.gone_since.reset();
      } else if (!state.gone_since) {
        state.gone_since = Clock::now();
      }
      if (!there && Clock::now() - *state.gone_since > kBack) {
        state.outcome = Problem{device_of(q),
                                std::string{"it was lost before it answered command "} + to_text(q.kind), ""};
      } else if (q.limit && Clock::now() - *state.sent > *q.limit) {
        state.outcome = Problem{
            device_of(q),
            std::string{"no answer to command "} + to_text(q.kind) + " within " + takt::to_text(*q.limit),
            ""};
      }
      return;
    }
    if (alive.size() > 1) {
      std::string where;
      for (const wire::ObservedDevice& seen : alive) {
        where += (where.empty() ? "process " : ", process ") + std::to_string(seen.status.process_id()) +
                 " on " + seen.status.host_name().to_string();
      }
      state.outcome = Problem{device_of(q),
                              std::to_string(alive.size()) + " nodes on domain " + std::to_string(domain_) +
                                  " have this name: " + where,
                              "end all but one of them"};
      return;
    }
    if (alive.empty()) {
      if (Clock::now() - begun <= find_within) return;
      state.outcome = lost
                          ? Problem{device_of(q), "it is lost: its node no longer answers",
                                    "start its node again; with --resume, the node restores its deployment"}
                          : Problem{device_of(q), "not found: no answer within " + takt::to_text(find_within),
                                    "check that takt-node --device " + q.device + " is running on domain " +
                                        std::to_string(domain_)};
      return;
    }
    state.sent = Clock::now();
    state.node = alive[0].node();
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
      if (!states[i].outcome) advance(questions[i], states[i]);
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
        states[i].outcome = Problem{device_of(questions[i]), "no answer before the wait was cancelled", ""};
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

Problems problems_of(const wire::WholeReply& reply) {
  Problems problems;
  const json list = model::parse_json(reply.data);
  if (list.is_array()) {
    for (const json& entry : list) {
      if (!entry.is_object() || !entry.contains("what")) continue;
      problems.push_back({entry.value("where", ""), entry.value("what", ""), entry.value("fix", "")});
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
