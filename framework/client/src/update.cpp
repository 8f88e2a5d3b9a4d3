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

namespace takt::client {

namespace {

using json = nlohmann::ordered_json;

/// The longest time until all devices that have made their changes have heard this from each other.
constexpr Nanoseconds kDecided = std::chrono::seconds{20};

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
  Updated decide();
  // The outcome if no device has reported how the devices have decided.
  [[nodiscard]] std::string undecided() const {
    return "the devices decide together whether cell " + cell_.name +
           " is updated; takt status shows their decision";
  }
  Updated put_back(Problems problems);

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
    requests.back().data = safe_;
  }
  Answers answers = send(requests);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i] && answers[i]->head.code() == REPLY_FAILED &&
        answers[i]->head.value() != std::string{wire::kAsBefore})
      not_restored_.push_back(devices_[i]);
  }
  Problems problems = problems_in(std::move(answers));
  return cancelled() ? Problems{fail("the update was cancelled")} : problems;
}

// Waits until the devices have decided whether they keep the update. As all of them have made their changes,
// they keep it unless one of them fails now.
Updated Update::decide() {
  std::vector<CommandRequest> requests;
  for (const std::string& device : devices_) {
    requests.push_back(request(COMMAND_KEEP, device));
    requests.back().limit = kDecided;
  }
  Answers answers = send(requests, false);
  bool kept = false;
  bool undone = false;
  std::vector<std::string> silent;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    kept |= answers[i] && answers[i]->head.code() == REPLY_OK;
    undone |= answers[i] && answers[i]->head.code() == REPLY_FAILED;
    if (!answers[i]) silent.push_back(devices_[i]);
  }
  const std::string later = silent.empty() ? "" : "; " + list_of(silent) + " did not confirm this yet";
  Problems problems = problems_in(std::move(answers));
  if (kept) return {std::move(problems), "cell " + cell_.name + " is updated" + later};
  if (undone)
    return {std::move(problems), "cell " + cell_.name + " is not updated; all changes are undone" + later};
  return {std::move(problems), undecided()};
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
  bool kept = false;
  bool undone = false;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    kept |= answers[i] && answers[i]->head.value() == std::string{wire::kKept};
    const auto answer = accepted(std::move(answers[i]));
    undone |= answer.ok();
    if (answer) continue;
    for (const Problem& problem : of_device(requests[i].device, answer.problems())) {
      if (std::find(problems.begin(), problems.end(), problem) == problems.end()) problems.push_back(problem);
    }
    not_restored_.push_back(requests[i].device);
  }
  if (kept)
    return {std::move(problems),
            "cell " + cell_.name + " is updated, because all devices had made their changes"};
  if (!undone) return {std::move(problems), undecided()};
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
  return decide();
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
