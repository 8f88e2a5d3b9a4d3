#include <takt/client/update.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/client/deploy.hpp>
#include <takt/wire/words.hpp>
#include <takt/model/difference.hpp>
#include <takt/model/json.hpp>
#include <takt/model/ports.hpp>
#include <takt/model/safe.hpp>
#include "answers.hpp"

namespace takt::client {

namespace {

using json = nlohmann::ordered_json;

std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

class Update {
 public:
  Update(Operator& asker, const model::Cell& cell, const UpdateOptions& options)
      : asker_(asker), cell_(cell), options_(options), id_(new_id()) {}

  Updated carry_out(const std::string& text);

 private:
  using Answers = std::vector<Result<wire::WholeReply>>;

  Problems find();
  Problems compare(const std::string& text);
  Problems change();
  Problems keep();
  Updated put_back(Problems problems);

  [[nodiscard]] bool cancelled() const { return options_.cancelled && options_.cancelled(); }
  void show_progress(const std::string& text) const {
    if (options_.progress) options_.progress(text);
  }
  [[nodiscard]] Question question(CommandKind kind, const std::string& device) const {
    return {
        .kind = kind, .device = device, .deployment = deployment_, .property = id_, .limit = std::nullopt};
  }
  Answers ask(const std::vector<Question>& questions, bool may_be_cancelled = true);
  Problems problems_in(Answers answers, std::vector<wire::WholeReply>* replies = nullptr) const;

  Operator& asker_;
  const model::Cell& cell_;
  const UpdateOptions& options_;
  std::string id_;
  std::string deployment_;
  std::vector<std::string> devices_;       // devices of the running cell and of the new descriptor
  std::vector<std::string> differences_;   // one line of text for each difference
  std::vector<std::string> changing_;      // devices on which the update changes something
  std::set<std::string> rejecting_;        // devices that rejected the update, so that they have nothing to
                                           // undo
  std::vector<std::string> not_restored_;  // devices that could not undo their changes
  std::int64_t t0_ns_ = 0;
  bool require_real_time_ = false;
  std::string safe_;
  KeepAlive keep_alive_;
};

Update::Answers Update::ask(const std::vector<Question>& questions, bool may_be_cancelled) {
  keep_alive_.sent();
  return asker_.ask(questions, [&] {
    keep_alive_.send(asker_, devices_,
                     [this](CommandKind kind, const std::string& name) { return question(kind, name); });
    return cancelled() && may_be_cancelled;
  });
}

// Returns the problems in the answers. Each problem is returned only once, because every device reports a
// problem that concerns the whole cell.
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
  const auto there = devices_of(asker_, cell_.name);
  if (!there) {
    Problem problem = there.problems()[0];
    problem.fix += (problem.fix.empty() ? "" : "; ") + std::string{"start the cell with takt deploy"};
    return {problem};
  }
  Problems problems;
  for (const std::string& device : there->lost)
    problems.push_back({"device " + device, "it is lost; an update needs all devices",
                        "start its node again with --resume, or undeploy the cell and deploy it again"});
  devices_ = there->names;
  for (const model::Device& device : cell_.devices) {
    if (std::find(devices_.begin(), devices_.end(), device.name) == devices_.end())
      devices_.push_back(device.name);
  }
  for (const wire::ObservedDevice& seen : asker_.observer().devices(there->names[0])) {
    if (seen.alive) deployment_ = seen.status.deployment().to_string();
  }
  return problems;
}

Problems Update::compare(const std::string& text) {
  show_progress("comparing the running cell with the new descriptor on " + list_of(devices_));
  std::vector<Question> questions;
  for (const std::string& device : devices_) {
    questions.push_back(question(COMMAND_UPDATE, device));
    questions.back().value = wire::cut(cell_.file, 255);
    questions.back().data = text;
  }
  std::vector<wire::WholeReply> replies;
  Answers answers = ask(questions);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i] && answers[i]->head.code() == REPLY_REFUSED) rejecting_.insert(devices_[i]);
  }
  Problems problems = problems_in(std::move(answers), &replies);
  if (cancelled()) return {fail("the update was cancelled")};
  if (!problems.empty()) return problems;
  for (std::size_t i = 0; i < replies.size(); ++i) {
    const json answer = model::parse_json(replies[i].data);
    if (!answer.is_object())
      return {{"device " + devices_[i], "its answer cannot be read",
               "check that it runs the same version of Takt as this program"}};
    if (answer.value("change", "") != model::to_text(model::Change::none)) changing_.push_back(devices_[i]);
    for (const std::string& line : answer.value("words", std::vector<std::string>{}))
      differences_.push_back(line);
    if (!answer.contains("t0_ns")) continue;
    t0_ns_ = answer["t0_ns"].get<std::int64_t>();
    require_real_time_ = answer.value("require_real_time", false);
  }
  const model::CellPorts ports = ports_of(cell_, replies);
  safe_ = model::safe_json(model::safe_outputs(cell_, ports));
  return model::check_connections(cell_, ports);
}

Problems Update::change() {
  show_progress("changing " + list_of(changing_));
  std::vector<Question> questions;
  for (const std::string& device : devices_) {
    questions.push_back(question(COMMAND_CHANGE, device));
    questions.back().time_ns = t0_ns_;
    questions.back().value = require_real_time_ ? wire::kRequireRealTime : "";
    questions.back().data = safe_;
  }
  Answers answers = ask(questions);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i] && answers[i]->head.code() == REPLY_FAILED &&
        answers[i]->head.value() != std::string{wire::kAsBefore})
      not_restored_.push_back(devices_[i]);
  }
  Problems problems = problems_in(std::move(answers));
  return cancelled() ? Problems{fail("the update was cancelled")} : problems;
}

// Asks the devices to make their changes permanent. A device that has done this cannot undo its changes any
// more.
Problems Update::keep() {
  std::vector<Question> questions;
  for (const std::string& device : devices_) questions.push_back(question(COMMAND_KEEP, device));
  return problems_in(ask(questions, false));
}

Updated Update::put_back(Problems problems) {
  const std::string name = "cell " + cell_.name + " is not updated; ";
  std::vector<Question> questions;
  for (const std::string& device : devices_) {
    if (rejecting_.contains(device)) continue;
    // A device without a live node has nothing to undo, so it is not asked.
    const auto seen = asker_.observer().devices(device);
    if (std::any_of(seen.begin(), seen.end(), [](const wire::ObservedDevice& s) { return s.alive; }))
      questions.push_back(question(COMMAND_PUT_BACK, device));
  }
  Answers answers = ask(questions, false);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const auto answer = accepted(std::move(answers[i]));
    if (answer) continue;
    for (const Problem& problem : of_device(questions[i].device, answer.problems())) {
      if (std::find(problems.begin(), problems.end(), problem) == problems.end()) problems.push_back(problem);
    }
    not_restored_.push_back(questions[i].device);
  }
  if (!not_restored_.empty())
    return {std::move(problems), name + "its changes could not be undone on " + list_of(not_restored_) +
                                     "; takt status shows the present state"};
  return {std::move(problems), name + "all changes were undone"};
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
  if (Problems problems = change(); !problems.empty()) {
    show_progress("undoing the changes");
    return put_back(std::move(problems));
  }
  if (Problems problems = keep(); !problems.empty())
    return {std::move(problems), "cell " + cell_.name +
                                     " is changed, but not all devices confirmed the change; run takt deploy "
                                     "--update again"};
  return {{}, "cell " + cell_.name + " is updated"};
}

}  // namespace

Updated update(Operator& asker, const model::Cell& cell, const std::string& text,
               const UpdateOptions& options) {
  if (text.size() > wire::kMaxData)
    return {{fail("the descriptor is larger than " + std::to_string(wire::kMaxData >> 20U) + " MiB",
                  "make it smaller")},
            "nothing was changed"};
  return Update{asker, cell, options}.carry_out(text);
}

}  // namespace takt::client
