#include <takt/client/update.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/client/answer_data.hpp>
#include <takt/client/deploy.hpp>
#include <takt/model/difference.hpp>
#include <takt/model/json.hpp>
#include <takt/model/ports.hpp>
#include <takt/model/safe.hpp>
#include <takt/wire/words.hpp>
#include "answers.hpp"
#include "decision.hpp"

namespace takt::client {

namespace {

using json = nlohmann::ordered_json;

/// The longest time until all devices know that another one has gone back, or is final.
constexpr Nanoseconds kAgreed = std::chrono::seconds{6};

std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

class Update {
 public:
  Update(Operator& sender, const model::Cell& cell, const UpdateOptions& options)
      : sender_(sender), cell_(cell), options_(options), id_(new_id()) {}

  Updated carry_out(const std::string& text);

 private:
  using Answers = std::vector<Result<wire::WholeReply>>;

  Problems find();
  Problems compare(const std::string& text);
  Problems change();
  Problems run();
  // The outcome if no device has reported how the devices have decided.
  [[nodiscard]] std::string undecided() const {
    return "the devices decide together whether cell " + cell_.name +
           " is updated; takt status shows their decision";
  }
  Updated put_back(Problems problems);
  [[nodiscard]] std::size_t in_stage(TransactionStage stage) const;
  [[nodiscard]] std::size_t wait_for_agreement() const;

  [[nodiscard]] bool cancelled() const { return options_.cancelled && options_.cancelled(); }
  void show_progress(const std::string& text) const {
    if (options_.progress) options_.progress(text);
  }
  [[nodiscard]] CommandRequest request(CommandKind kind, const std::string& device) const {
    return {
        .kind = kind, .device = device, .deployment = deployment_, .property = id_, .limit = std::nullopt};
  }
  Answers send(const std::vector<CommandRequest>& requests, bool may_be_cancelled = true);
  Problems problems_in(Answers answers, std::vector<wire::WholeReply>* replies = nullptr) const;

  Operator& sender_;
  const model::Cell& cell_;
  const UpdateOptions& options_;
  std::string id_;
  std::string deployment_;
  std::vector<std::string> devices_;       // devices of the running cell or of the new descriptor
  std::vector<std::string> differences_;   // one line of text for each difference
  std::vector<std::string> changing_;      // devices on which the update changes something
  std::set<std::string> rejecting_;        // devices that rejected the update, so they have nothing to
                                           // undo
  std::vector<std::string> not_restored_;  // devices that could not undo their changes
  std::int64_t t0_ns_ = 0;
  bool require_real_time_ = false;
  std::string safe_;
  Nanoseconds took_{0};    // how long the devices took to make their changes
  bool run_sent_ = false;  // the devices may have received T0, so they decide together
  KeepAlive keep_alive_;
};

Update::Answers Update::send(const std::vector<CommandRequest>& requests, bool may_be_cancelled) {
  keep_alive_.sent();
  return sender_.send(requests, [&] {
    keep_alive_.send(sender_, devices_,
                     [this](CommandKind kind, const std::string& name) { return request(kind, name); });
    return cancelled() && may_be_cancelled;
  });
}

// Returns the problems in the answers, each problem only once, because several devices may report the same
// problem of the whole cell. Stores the answers with REPLY_OK in `replies`.
Problems Update::problems_in(Answers answers, std::vector<wire::WholeReply>* replies) const {
  Problems problems;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const auto answer = accepted(std::move(answers[i]));
    if (answer) {
      if (replies != nullptr) replies->push_back(*answer);
      continue;
    }
    for (const Problem& problem : answer.problems()) {
      // A problem that cites a line of the descriptor needs no device name.
      const bool of_file = !cell_.file.empty() && problem.where.find(':') != std::string::npos;
      const Problem placed = of_file ? problem : of_device(devices_[i], {problem})[0];
      if (std::find(problems.begin(), problems.end(), placed) == problems.end()) problems.push_back(placed);
    }
  }
  return problems;
}

// Finds the devices that run the cell now or will run it after the update.
Problems Update::find() {
  const auto there = devices_of(sender_, cell_.name);
  if (!there) {
    Problem problem = there.problems()[0];
    problem.fix += (problem.fix.empty() ? "" : "; ") + std::string{"start the cell with takt deploy"};
    return {problem};
  }
  Problems problems;
  for (const std::string& device : there->lost)
    problems.push_back({"device " + device, "it is not reached; an update needs all devices",
                        "start its node again with --resume, or undeploy the cell and deploy it again"});
  devices_ = there->names;
  for (const model::Device& device : cell_.devices) {
    if (std::find(devices_.begin(), devices_.end(), device.name) == devices_.end())
      devices_.push_back(device.name);
  }
  deployment_ = there->deployment;
  return problems;
}

Problems Update::compare(const std::string& text) {
  show_progress("comparing the running cell with the new descriptor on " + list_of(devices_));
  std::vector<CommandRequest> requests;
  for (const std::string& device : devices_) {
    requests.push_back(request(COMMAND_UPDATE, device));
    requests.back().value = wire::cut(cell_.file, 255);
    requests.back().data = text;
  }
  std::vector<wire::WholeReply> replies;
  Answers answers = send(requests);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i] && answers[i]->head.code() == REPLY_REFUSED) rejecting_.insert(devices_[i]);
  }
  Problems problems = problems_in(std::move(answers), &replies);
  if (cancelled()) return {fail("the update was cancelled")};
  if (!problems.empty()) return problems;
  for (std::size_t i = 0; i < replies.size(); ++i) {
    const auto read = read_answer(devices_[i], replies[i].data, [&](const json& answer) {
      if (answer.value("change", "") != model::to_text(model::Change::none)) changing_.push_back(devices_[i]);
      for (const std::string& line : answer.value("words", std::vector<std::string>{}))
        differences_.push_back(line);
      if (!answer.contains("t0_ns")) return;
      t0_ns_ = answer.at("t0_ns").get<std::int64_t>();
      require_real_time_ = answer.value("require_real_time", false);
    });
    if (!read) return read.problems();
  }
  const auto ports = ports_of(cell_, replies);
  if (!ports) return ports.problems();
  safe_ = model::safe_json(model::safe_outputs(cell_, *ports));
  return model::check_connections(cell_, *ports);
}

Problems Update::change() {
  show_progress("changing " + list_of(changing_));
  std::vector<CommandRequest> requests;
  for (const std::string& device : devices_) {
    requests.push_back(request(COMMAND_CHANGE, device));
    requests.back().time_ns = t0_ns_;
    requests.back().value = require_real_time_ ? wire::kRequireRealTime : "";
    requests.back().data = model::json_text({{"devices", devices_}, {"safe", model::parse_json(safe_)}});
  }
  const auto begin = std::chrono::steady_clock::now();
  Answers answers = send(requests);
  took_ = std::chrono::steady_clock::now() - begin;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i] && answers[i]->head.code() == REPLY_FAILED &&
        answers[i]->head.value() != std::string{wire::kAsBefore})
      not_restored_.push_back(devices_[i]);
  }
  Problems problems = problems_in(std::move(answers));
  return cancelled() ? Problems{fail("the update was cancelled")} : problems;
}

// Sends T0, and waits until each device is final. From then on no device undoes the update.
Problems Update::run() {
  const std::int64_t t0_ns = choose_t0(took_);
  std::vector<CommandRequest> requests;
  for (const std::string& device : devices_) {
    requests.push_back(request(COMMAND_RUN, device));
    requests.back().time_ns = t0_ns;
    requests.back().limit = time_to_confirm(t0_ns);
  }
  run_sent_ = true;
  Problems problems = problems_in(send(requests));
  if (cancelled()) return {fail("the update was cancelled")};
  if (!problems.empty()) return problems;
  const auto stands =
      wait_until_decided(sender_.observer(), devices_, {.id = id_, .deployment = deployment_, .t0_ns = t0_ns},
                         [this] { return cancelled(); });
  for (std::size_t i = 0; i < devices_.size(); ++i) {
    const std::string where = "device " + devices_[i];
    switch (stands[i]) {
      case Stands::final:
        break;
      case Stands::undecided:
        problems.push_back(
            {where, "it has not heard that all other devices have made their changes", "check the network"});
        break;
      case Stands::lost:
        problems.push_back(
            {where, "it was lost before it confirmed the update", "check its machine and network"});
        break;
      case Stands::undone:
        problems.push_back({where, "it has undone the update", ""});
        break;
    }
  }
  if (!problems.empty() && cancelled()) return {fail("the update was cancelled")};
  return problems;
}

Updated Update::put_back(Problems problems) {
  const std::string name = "cell " + cell_.name + " is not updated; ";
  std::vector<CommandRequest> requests;
  for (const std::string& device : devices_) {
    if (rejecting_.contains(device)) continue;
    // A device without a live node has nothing to undo, so it gets no command.
    const auto seen = sender_.observer().devices(device);
    if (std::any_of(seen.begin(), seen.end(), [](const wire::ObservedDevice& s) { return s.alive; }))
      requests.push_back(request(COMMAND_PUT_BACK, device));
  }
  Answers answers = send(requests, false);
  bool undone = false;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const bool kept = answers[i] && answers[i]->head.value() == std::string{wire::kKept};
    const auto answer = accepted(std::move(answers[i]));
    undone |= answer.ok();
    if (answer || kept) continue;
    for (const Problem& problem : of_device(requests[i].device, answer.problems())) {
      if (std::find(problems.begin(), problems.end(), problem) == problems.end()) problems.push_back(problem);
    }
    not_restored_.push_back(requests[i].device);
  }
  const std::size_t final = run_sent_ ? wait_for_agreement() : 0;
  if (final != 0) {
    const std::string later = final == devices_.size() ? "" : "; not all devices have confirmed this yet";
    return {std::move(problems),
            "cell " + cell_.name + " is updated, because all devices had made their changes" + later};
  }
  const bool all_undone = run_sent_ ? in_stage(STAGE_UNDONE) == devices_.size() : undone;
  if (!all_undone) return {std::move(problems), undecided()};
  if (!not_restored_.empty())
    return {std::move(problems), name + "its changes could not be undone on " + list_of(not_restored_) +
                                     "; takt status shows the present state"};
  return {std::move(problems), name + "all changes were undone"};
}

// Returns how many devices are known to be in this stage of the update.
std::size_t Update::in_stage(TransactionStage stage) const {
  std::set<std::string> found;
  for (const wire::ObservedDevice& seen : sender_.observer().devices()) {
    if (seen.alive && seen.status.transaction() == id_ && seen.status.stage() == stage)
      found.insert(seen.name());
  }
  return found.size();
}

// Waits until all devices have gone back, or all are final. Returns how many devices are final.
std::size_t Update::wait_for_agreement() const {
  sender_.observer().wait(
      [this](const auto&) {
        return in_stage(STAGE_UNDONE) == devices_.size() || in_stage(STAGE_FINAL) == devices_.size();
      },
      kAgreed);
  return in_stage(STAGE_FINAL);
}

Updated Update::carry_out(const std::string& text) {
  const std::string unchanged = "cell " + cell_.name + " is not updated; nothing was changed";
  if (Problems problems = find(); !problems.empty()) return {std::move(problems), unchanged};
  if (Problems problems = compare(text); !problems.empty())
    return {put_back(std::move(problems)).problems, unchanged};
  if (differences_.empty()) {
    static_cast<void>(put_back({}));
    return {{}, "nothing differs"};
  }
  if (options_.differs) options_.differs(differences_);
  Problems problems = change();
  if (problems.empty()) problems = run();
  if (problems.empty()) return {{}, "cell " + cell_.name + " is updated"};
  show_progress("undoing the changes");
  return put_back(std::move(problems));
}

}  // namespace

Updated update(Operator& sender, const model::Cell& cell, const std::string& text,
               const UpdateOptions& options) {
  if (text.size() > wire::kMaxData)
    return {{fail("the descriptor is larger than " + std::to_string(wire::kMaxData >> 20U) + " MiB",
                  "make it smaller")},
            "nothing was changed"};
  return Update{sender, cell, options}.carry_out(text);
}

}  // namespace takt::client
