#include "coordinator.hpp"

#include <algorithm>
#include <chrono>
#include <set>
#include <utility>

#include <takt/client/answer_data.hpp>
#include <takt/model/json.hpp>
#include <takt/model/ports.hpp>
#include <takt/model/safe.hpp>
#include <takt/wire/words.hpp>
#include "answers.hpp"

namespace takt::client {

namespace {

using json = nlohmann::ordered_json;

/// How far ahead T0 lies. A device begins up to 300 ms before T0 (transaction::kBegins), and in this time the
/// devices hear from each other that all have T0.
constexpr Nanoseconds kShortestLead = std::chrono::milliseconds{400};
constexpr Nanoseconds kLongestLead = std::chrono::milliseconds{3000};
/// Each device must confirm T0 at least this time before T0. If a device does not confirm in time, the
/// operator can still cancel before T0.
constexpr Nanoseconds kConfirmed = std::chrono::milliseconds{100};
/// The longest time after T0 until every device is final or has gone back.
constexpr Nanoseconds kDecided = std::chrono::seconds{6};
/// A device that receives nothing for some seconds undoes what it has prepared, because the operator may have
/// died. So it receives a request at this interval while the operator waits for a slower device.
constexpr std::chrono::seconds kKeptAliveEvery{4};
/// How long after T0 the operator looks for modules that fail in their first run.
constexpr Nanoseconds kFirstRun = std::chrono::milliseconds{150};

}  // namespace

CommandRequest Coordinator::request(CommandKind kind, const std::string& device) const {
  CommandRequest request{.kind = kind,
                         .device = device,
                         .deployment = plan_.deployment,
                         .property = plan_.id,
                         .limit = std::nullopt};
  const auto process = plan_.process_ids.find(device);
  if (process != plan_.process_ids.end()) request.process_id = process->second;
  return request;
}

std::vector<CommandRequest> Coordinator::requests(CommandKind kind) const {
  std::vector<CommandRequest> all;
  for (const std::string& device : plan_.devices) all.push_back(request(kind, device));
  return all;
}

Coordinator::Answers Coordinator::send(const std::vector<CommandRequest>& requests, bool may_be_cancelled) {
  sent_at_ = std::chrono::steady_clock::now();
  return sender_.send(requests, [&] {
    keep_alive();
    return may_be_cancelled && cancelled();
  });
}

void Coordinator::keep_alive() {
  if (std::chrono::steady_clock::now() - sent_at_ < kKeptAliveEvery) return;
  sent_at_ = std::chrono::steady_clock::now();
  auto all = requests(COMMAND_REPORT);
  for (CommandRequest& one : all) one.limit = std::chrono::milliseconds{500};
  static_cast<void>(sender_.send(all));
}

Problems Coordinator::problems_in(const std::vector<CommandRequest>& requests, const Answers& answers) {
  Problems problems;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    undeployed_ |= answers[i] && answers[i]->head.value() == std::string{wire::kUndeployed};
    const auto answer = accepted(answers[i]);
    if (answer) continue;
    for (const Problem& problem : answer.problems()) {
      // A problem that cites a line of the descriptor needs no device name.
      const bool of_file = !plan_.cell.file.empty() && problem.where.find(':') != std::string::npos;
      const Problem placed = of_file ? problem : of_device(requests[i].device, {problem})[0];
      if (std::find(problems.begin(), problems.end(), placed) == problems.end()) problems.push_back(placed);
    }
  }
  if (cancelled()) return cancelled_problem();
  if (const auto cut = problems.empty() ? std::nullopt : cut_off()) return {*cut};
  return problems;
}

std::optional<Problem> Coordinator::cut_off() const {
  const auto alive = [this](const std::string& device) { return is_alive(device); };
  if (plan_.devices.size() < 2 || std::any_of(plan_.devices.begin(), plan_.devices.end(), alive)) return {};
  return fail("this machine has lost all devices of the cell at the same moment", "check its own network");
}

Problems Coordinator::prepare(const std::string& text,
                              const std::function<void(const std::string&, const json&)>& read) {
  auto all = requests(COMMAND_PREPARE);
  for (CommandRequest& one : all) {
    one.value = wire::cut(plan_.cell.file, 255);
    one.data = text;
  }
  const Answers answers = send(all);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i] && answers[i]->head.code() == REPLY_REFUSED) rejecting_.insert(all[i].device);
  }
  if (Problems problems = problems_in(all, answers); !problems.empty()) return problems;
  std::vector<wire::WholeReply> replies;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    replies.push_back(*answers[i]);
    if (!read) continue;
    const auto done =
        read_answer(all[i].device, replies[i].data, [&](const json& answer) { read(all[i].device, answer); });
    if (!done) return done.problems();
  }
  const auto ports = ports_of(plan_.cell, replies);
  if (!ports) return ports.problems();
  safe_ = model::safe_json(model::safe_outputs(plan_.cell, *ports));
  return model::check_connections(plan_.cell, *ports);
}

Problems Coordinator::change(std::int64_t t0_ns, bool require_real_time) {
  auto all = requests(COMMAND_CHANGE);
  change_sent_ = true;
  for (CommandRequest& one : all) {
    one.time_ns = t0_ns;
    one.value = require_real_time ? wire::kRequireRealTime : "";
    one.data = model::json_text({{"devices", plan_.devices}, {"safe", model::parse_json(safe_)}});
  }
  const Answers answers = send(all);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i] && answers[i]->head.code() == REPLY_FAILED &&
        answers[i]->head.value() != std::string{wire::kAsBefore})
      not_restored_.insert(all[i].device);
  }
  return problems_in(all, answers);
}

Problems Coordinator::cancelled_problem() const {
  return {fail("the " + plan_.name + " was cancelled before all devices were " +
               (run_sent_ ? "final" : "ready"))};
}

// The longer the devices take to answer a question, the further ahead T0 lies.
Problems Coordinator::run() {
  const auto questions = requests(COMMAND_REPORT);
  const auto begin = std::chrono::steady_clock::now();
  if (Problems problems = problems_in(questions, send(questions)); !problems.empty()) return problems;
  const Nanoseconds took = std::chrono::steady_clock::now() - begin;
  t0_ns_ = wall_ns() + std::min(kShortestLead + 10 * took, kLongestLead).count();
  auto all = requests(COMMAND_RUN);
  const Nanoseconds left = Nanoseconds{t0_ns_ - wall_ns()} - kConfirmed;
  for (CommandRequest& one : all) {
    one.time_ns = t0_ns_;
    one.limit = std::max(std::chrono::floor<std::chrono::milliseconds>(left), std::chrono::milliseconds{1});
  }
  run_sent_ = true;
  if (Problems problems = problems_in(all, send(all)); !problems.empty()) return problems;
  return decided();
}

// Waits until each device is final, or until one of them has undone the deployment or update; at most some
// seconds after T0. Once a device is final, no device undoes it any more.
Problems Coordinator::decided() const {
  std::vector<Stands> all;
  const auto judge = [&](const std::vector<wire::ObservedDevice>& seen) {
    all.clear();
    for (const std::string& device : plan_.devices) all.push_back(stands(seen, device));
  };
  sender_.observer().wait(
      [&](const std::vector<wire::ObservedDevice>& seen) {
        judge(seen);
        return std::count(all.begin(), all.end(), Stands::undone) != 0 ||
               std::count(all.begin(), all.end(), Stands::final) == std::ssize(all) || cancelled();
      },
      Nanoseconds{t0_ns_ - wall_ns()} + kDecided);
  judge(sender_.observer().devices());
  if (const auto cut = cut_off()) return {*cut};
  Problems problems;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::string where = "device " + plan_.devices[i];
    if (all[i] == Stands::undecided)
      problems.push_back({where, "it has not heard from all other devices", "check the network"});
    else if (all[i] == Stands::lost)
      problems.push_back(
          {where, "it was lost before it confirmed the " + plan_.name, "check its machine and network"});
    else if (all[i] == Stands::undone)
      problems.push_back({where, "it has undone the " + plan_.name, ""});
  }
  return !problems.empty() && cancelled() ? cancelled_problem() : problems;
}

Coordinator::Stands Coordinator::stands(const std::vector<wire::ObservedDevice>& seen,
                                        const std::string& device) const {
  Stands found = Stands::lost;
  for (const wire::ObservedDevice& one : seen) {
    if (!one.alive || one.name() != device) continue;
    const DeviceStatus& status = one.status;
    const bool has_t0 = status.transaction() == plan_.id && status.t0_ns() == t0_ns_;
    if (!has_t0 || status.stage() == STAGE_UNDONE || status.undeployed() == plan_.deployment) {
      // Before T0, an older status may still be on its way.
      if (found == Stands::lost) found = wall_ns() > t0_ns_ ? Stands::undone : Stands::undecided;
    } else {
      found = status.stage() == STAGE_FINAL ? Stands::final : Stands::undecided;
    }
  }
  return found;
}

Problems Coordinator::failed_modules() const {
  const auto mine = [this](const wire::ObservedDevice& seen) {
    return seen.alive && seen.status.deployment() == plan_.deployment;
  };
  const auto failed = [](const wire::ObservedDevice& seen) {
    return seen.status.health() == HEALTH_DEGRADED && seen.status.text().to_string().starts_with("module ");
  };
  sender_.observer().wait(
      [&](const std::vector<wire::ObservedDevice>& devices) {
        return std::all_of(devices.begin(), devices.end(), [&](const wire::ObservedDevice& seen) {
          return !mine(seen) || failed(seen) || seen.status.executing() == seen.status.modules();
        });
      },
      Nanoseconds{std::max(t0_ns_ - wall_ns(), std::int64_t{0})} + kFirstRun);
  Problems problems;
  for (const wire::ObservedDevice& seen : sender_.observer().devices()) {
    if (mine(seen) && failed(seen))
      problems.push_back({"device " + seen.name(), seen.status.text().to_string(), ""});
  }
  return problems;
}

bool Coordinator::is_alive(const std::string& device) const {
  const auto seen = sender_.observer().devices(device);
  return std::any_of(seen.begin(), seen.end(), [](const wire::ObservedDevice& one) { return one.alive; });
}

std::set<std::string> Coordinator::in_stage(TransactionStage stage) const {
  std::set<std::string> found;
  for (const wire::ObservedDevice& seen : sender_.observer().devices()) {
    if (seen.alive && seen.status.transaction() == plan_.id && seen.status.stage() == stage)
      found.insert(seen.name());
  }
  return found;
}

}  // namespace takt::client
