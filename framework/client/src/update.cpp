#include <takt/client/update.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/client/deploy.hpp>
#include <takt/dds/words.hpp>
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
  using Answers = std::vector<Result<dds::WholeReply>>;

  Problems find();
  Problems compare(const std::string& text);
  Problems change();
  Problems keep();
  Updated put_back(Problems problems);

  [[nodiscard]] bool cancelled() const { return options_.cancelled && options_.cancelled(); }
  void tell(const std::string& text) const {
    if (options_.progress) options_.progress(text);
  }
  [[nodiscard]] Question question(CommandKind kind, const std::string& device) const {
    return {
        .kind = kind, .device = device, .deployment = deployment_, .property = id_, .limit = std::nullopt};
  }
  Answers ask(const std::vector<Question>& questions, bool may_be_cancelled = true);
  Problems problems_in(Answers answers, std::vector<dds::WholeReply>* replies = nullptr) const;

  Operator& asker_;
  const model::Cell& cell_;
  const UpdateOptions& options_;
  std::string id_;
  std::string deployment_;
  std::vector<std::string> devices_;        // that the cell has now, and that it is to have
  std::vector<std::string> words_;          // what differs
  std::vector<std::string> changing_;       // devices on which something does
  std::set<std::string> refusing_;          // that did not begin with it
  std::vector<std::string> not_as_before_;  // where putting it back failed
  std::int64_t t0_ns_ = 0;
  bool require_real_time_ = false;
  std::string safe_;
  SignOfLife sign_of_life_;
};

Update::Answers Update::ask(const std::vector<Question>& questions, bool may_be_cancelled) {
  sign_of_life_.given();
  return asker_.ask(questions, [&] {
    sign_of_life_.give(asker_, devices_,
                       [this](CommandKind kind, const std::string& name) { return question(kind, name); });
    return cancelled() && may_be_cancelled;
  });
}

// Each reason once: what is wrong with the whole cell all devices say.
Problems Update::problems_in(Answers answers, std::vector<dds::WholeReply>* replies) const {
  Problems problems;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const auto answer = accepted(std::move(answers[i]));
    if (answer) {
      if (replies != nullptr) replies->push_back(*answer);
      continue;
    }
    for (const Problem& problem : answer.problems()) {
      // One that has a line says where it is.
      const bool of_file = !cell_.file.empty() && problem.where.find(':') != std::string::npos;
      const Problem told = of_file ? problem : of_device(devices_[i], {problem})[0];
      if (std::find(problems.begin(), problems.end(), told) == problems.end()) problems.push_back(told);
    }
  }
  return problems;
}

// All that run the cell, and are to.
Problems Update::find() {
  const auto there = devices_of(asker_, cell_.name);
  if (!there) {
    Problem problem = there.problems()[0];
    problem.fix += (problem.fix.empty() ? "" : "; ") + std::string{"takt deploy starts it"};
    return {problem};
  }
  Problems problems;
  for (const std::string& device : there->lost)
    problems.push_back({"device " + device, "it is lost, and an update is one of all devices",
                        "start its node again with --resume, or undeploy the cell and deploy it"});
  devices_ = there->names;
  for (const model::Device& device : cell_.devices) {
    if (std::find(devices_.begin(), devices_.end(), device.name) == devices_.end())
      devices_.push_back(device.name);
  }
  for (const dds::ObservedDevice& seen : asker_.observer().devices(there->names[0])) {
    if (seen.alive) deployment_ = seen.status.deployment().to_string();
  }
  return problems;
}

Problems Update::compare(const std::string& text) {
  tell("comparing on " + list_of(devices_));
  std::vector<Question> questions;
  for (const std::string& device : devices_) {
    questions.push_back(question(COMMAND_UPDATE, device));
    questions.back().value = dds::cut(cell_.file, 255);
    questions.back().data = text;
  }
  std::vector<dds::WholeReply> replies;
  Answers answers = ask(questions);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i] && answers[i]->head.code() == REPLY_REFUSED) refusing_.insert(devices_[i]);
  }
  Problems problems = problems_in(std::move(answers), &replies);
  if (cancelled()) return {fail("it was given up")};
  if (!problems.empty()) return problems;
  for (std::size_t i = 0; i < replies.size(); ++i) {
    const json said = model::parse_json(replies[i].data);
    if (!said.is_object()) return {{"device " + devices_[i], "it gave an answer that cannot be read", ""}};
    if (said.value("change", "") != model::to_text(model::Change::none)) changing_.push_back(devices_[i]);
    for (const std::string& line : said.value("words", std::vector<std::string>{})) words_.push_back(line);
    if (!said.contains("t0_ns")) continue;
    t0_ns_ = said["t0_ns"].get<std::int64_t>();
    require_real_time_ = said.value("require_real_time", false);
  }
  const model::CellPorts ports = ports_of(cell_, replies);
  safe_ = model::safe_json(model::safe_outputs(cell_, ports));
  return model::check_connections(cell_, ports);
}

Problems Update::change() {
  tell("changing " + list_of(changing_));
  std::vector<Question> questions;
  for (const std::string& device : devices_) {
    questions.push_back(question(COMMAND_CHANGE, device));
    questions.back().time_ns = t0_ns_;
    questions.back().value = require_real_time_ ? dds::kRequireRealTime : "";
    questions.back().data = safe_;
  }
  Answers answers = ask(questions);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i] && answers[i]->head.code() == REPLY_FAILED &&
        answers[i]->head.value() != std::string{dds::kAsBefore})
      not_as_before_.push_back(devices_[i]);
  }
  Problems problems = problems_in(std::move(answers));
  return cancelled() ? Problems{fail("it was given up")} : problems;
}

// Nobody goes back after this.
Problems Update::keep() {
  std::vector<Question> questions;
  for (const std::string& device : devices_) questions.push_back(question(COMMAND_KEEP, device));
  return problems_in(ask(questions, false));
}

Updated Update::put_back(Problems problems) {
  const std::string name = "cell " + cell_.name + " is not updated; ";
  std::vector<Question> questions;
  for (const std::string& device : devices_) {
    if (refusing_.contains(device)) continue;
    // One that is not there has kept what it had, and is not waited for.
    const auto seen = asker_.observer().devices(device);
    if (std::any_of(seen.begin(), seen.end(), [](const dds::ObservedDevice& s) { return s.alive; }))
      questions.push_back(question(COMMAND_PUT_BACK, device));
  }
  Answers answers = ask(questions, false);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const auto answer = accepted(std::move(answers[i]));
    if (answer) continue;
    for (const Problem& problem : of_device(questions[i].device, answer.problems())) {
      if (std::find(problems.begin(), problems.end(), problem) == problems.end()) problems.push_back(problem);
    }
    not_as_before_.push_back(questions[i].device);
  }
  if (!not_as_before_.empty())
    return {std::move(problems), name + "what had been changed could not be put back on " +
                                     list_of(not_as_before_) + "; takt status shows how it stands"};
  return {std::move(problems), name + "what had been changed was put back"};
}

Updated Update::carry_out(const std::string& text) {
  const std::string unchanged = "cell " + cell_.name + " is not updated; nothing was changed";
  if (Problems problems = find(); !problems.empty()) return {std::move(problems), unchanged};
  if (Problems problems = compare(text); !problems.empty())
    return {put_back(std::move(problems)).problems, unchanged};
  if (words_.empty()) {
    static_cast<void>(put_back({}));
    return {{}, "nothing differs"};
  }
  if (options_.differs) options_.differs(words_);
  if (Problems problems = change(); !problems.empty()) {
    tell("putting it back");
    return put_back(std::move(problems));
  }
  if (Problems problems = keep(); !problems.empty())
    return {std::move(problems), "cell " + cell_.name +
                                     " is changed, but not all devices keep it; takt deploy --update again "
                                     "makes them one"};
  return {{}, "cell " + cell_.name + " is updated"};
}

}  // namespace

Updated update(Operator& asker, const model::Cell& cell, const std::string& text,
               const UpdateOptions& options) {
  if (text.size() > dds::kMaxData)
    return {{fail("the descriptor has more than " + std::to_string(dds::kMaxData >> 20U) + " MiB",
                  "make it smaller")},
            "nothing was changed"};
  return Update{asker, cell, options}.carry_out(text);
}

}  // namespace takt::client
