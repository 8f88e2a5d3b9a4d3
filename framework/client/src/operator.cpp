#include <takt/client/operator.hpp>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <cstdio>
#include <map>
#include <mutex>
#include <random>

#include <nlohmann/json.hpp>

#include <takt/dds/words.hpp>
#include <takt/model/json.hpp>
#include "answers.hpp"

namespace takt::client {

namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;
using json = nlohmann::ordered_json;

/// Within which a node must begin what has no limit of its own.
constexpr std::chrono::seconds kBegun{10};
/// Within which a node that is there has been found, however long its answer may take.
constexpr Nanoseconds kFound = std::chrono::seconds{3};
/// Within which a node that is lost while it is asked may come back: its machine was busy, not dead.
constexpr Nanoseconds kBack = milliseconds{700};

std::string device_of(const Question& question) { return "device " + question.device; }

}  // namespace

struct Operator::Inside {
  std::mutex mutex;
  std::condition_variable answered;
  std::map<std::string, std::optional<dds::WholeReply>> open;  // by id of the command
  std::uint64_t asked = 0;
  std::string name;  // begins every id
  std::optional<dds::CommandClient> client;

  void heard(const dds::WholeReply& reply) {
    {
      const std::lock_guard lock{mutex};
      const auto found = open.find(reply.head.id().to_string());
      if (found == open.end() || found->second) return;
      found->second = reply;
    }
    answered.notify_all();
  }
};

Operator::Operator(std::unique_ptr<Inside> inside, const Observer& observer, int domain)
    : inside_(std::move(inside)), observer_(observer), domain_(domain) {}

Operator::~Operator() = default;

Result<std::unique_ptr<Operator>> Operator::create(std::shared_ptr<dds::Participant> participant,
                                                   const Observer& observer, int domain) {
  auto inside = std::make_unique<Inside>();
  Inside* const place = inside.get();
  std::random_device random;
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%08x%08x", random(), random());
  inside->name = digits.data();
  auto client = dds::CommandClient::create(std::move(participant),
                                           [place](const dds::WholeReply& reply) { place->heard(reply); });
  if (!client) return client.problems();
  inside->client.emplace(std::move(*client));
  return std::unique_ptr<Operator>{new Operator{std::move(inside), observer, domain}};
}

Result<dds::WholeReply> Operator::ask(const Question& question) {
  return std::move(ask(std::vector{question})[0]);
}

std::vector<Result<dds::WholeReply>> Operator::ask(const std::vector<Question>& questions,
                                                   const std::function<bool()>& give_up) {
  // One at a time is enough for each of them: found, asked, answered.
  struct State {
    std::string id;
    std::string node;
    std::optional<Clock::time_point> sent;
    std::optional<Clock::time_point> gone_since;
    std::optional<Result<dds::WholeReply>> outcome;
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

  const auto meant = [](const Question& q, const dds::ObservedDevice& seen) {
    return q.process_id == 0 || seen.status.process_id() == q.process_id;
  };
  const auto look = [&](const Question& q, State& state) {
    const Nanoseconds find_within = std::min(q.limit.value_or(kFound), kFound);
    std::vector<dds::ObservedDevice> alive;
    bool lost = false;
    for (const dds::ObservedDevice& seen : observer_.devices(q.device)) {
      if (!meant(q, seen)) continue;
      if (seen.alive)
        alive.push_back(seen);
      else
        lost = true;
    }
    if (state.sent) {
      const bool there = std::any_of(alive.begin(), alive.end(), [&](const dds::ObservedDevice& seen) {
        return seen.node() == state.node;
      });
      if (there) {
        state.gone_since.reset();
      } else if (!state.gone_since) {
        state.gone_since = Clock::now();
      }
      if (!there && Clock::now() - *state.gone_since > kBack) {
        state.outcome =
            Problem{device_of(q), std::string{"it was lost before it answered to "} + to_text(q.kind), ""};
      } else if (q.limit && Clock::now() - *state.sent > *q.limit) {
        state.outcome = Problem{
            device_of(q),
            std::string{"it gave no answer to "} + to_text(q.kind) + " within " + takt::to_text(*q.limit),
            ""};
      }
      return;
    }
    if (alive.size() > 1) {
      std::string where;
      for (const dds::ObservedDevice& seen : alive) {
        where += (where.empty() ? "process " : ", process ") + std::to_string(seen.status.process_id()) +
                 " on " + seen.status.host_name().to_string();
      }
      state.outcome = Problem{device_of(q),
                              std::to_string(alive.size()) + " nodes of this name are on domain " +
                                  std::to_string(domain_) + ": " + where,
                              "end all but one of them"};
      return;
    }
    if (alive.empty()) {
      if (Clock::now() - begun <= find_within) return;
      state.outcome =
          lost ? Problem{device_of(q), "it is lost: its node does not answer any more",
                         "start its node again; with --resume it takes up what it ran"}
               : Problem{device_of(q), "it is not there: no answer within " + takt::to_text(find_within),
                         "is takt-node --device " + q.device + " running on domain " +
                             std::to_string(domain_) + "?"};
      return;
    }
    state.sent = Clock::now();
    state.node = alive[0].node();
    dds::WholeCommand command;
    command.head.id(state.id);
    dds::set(command.head.device(), q.device);
    dds::set(command.head.node(), state.node);
    dds::set(command.head.module_name(), q.module);
    command.head.kind(q.kind);
    dds::set(command.head.deployment(), q.deployment);
    dds::set(command.head.property(), q.property);
    dds::set(command.head.value(), q.value);
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
      if (!states[i].outcome) look(questions[i], states[i]);
    }
    const bool enough = give_up && give_up();
    std::unique_lock lock{inside_->mutex};
    const auto take = [&] {
      bool taken = false;
      for (State& state : states) {
        auto& reply = inside_->open.at(state.id);
        if (!reply) continue;
        state.outcome = std::move(*reply);  // also where it came just after it was given up
        reply.reset();
        taken = true;
      }
      return taken;
    };
    if (take()) continue;
    for (std::size_t i = 0; enough && i < states.size(); ++i) {
      if (!states[i].outcome)
        states[i].outcome = Problem{device_of(questions[i]), "it was not waited for any more", ""};
    }
    if (open()) inside_->answered.wait_for(lock, milliseconds{10});
  }

  std::vector<Result<dds::WholeReply>> outcomes;
  outcomes.reserve(states.size());
  const std::lock_guard lock{inside_->mutex};
  for (State& state : states) {
    inside_->open.erase(state.id);
    inside_->client->forget(state.id);
    outcomes.push_back(std::move(*state.outcome));
  }
  return outcomes;
}

Problems problems_of(const dds::WholeReply& reply) {
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
    problems.push_back(
        {"device " + reply.head.device().to_string(), text.empty() ? "it gave no reason" : text, ""});
  }
  return problems;
}

Result<dds::WholeReply> accepted(Result<dds::WholeReply> answer) {
  if (!answer || answer->head.code() == REPLY_OK) return answer;
  return problems_of(*answer);
}

}  // namespace takt::client
