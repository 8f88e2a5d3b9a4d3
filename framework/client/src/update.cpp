#include <takt/client/update.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/client/answer_data.hpp>
#include <takt/client/undeploy.hpp>
#include <takt/model/difference.hpp>
#include <takt/wire/words.hpp>
#include "answers.hpp"
#include "coordinator.hpp"

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
  Update(Operator& sender, const model::Cell& cell, Plan plan)
      : sender_(sender), cell_(cell), coordinator_(sender, std::move(plan)) {}

  Problems compare(const std::string& text);
  Problems change();
  Problems run() { return coordinator_.run(); }
  Updated put_back(Problems problems);
  /// One line of text for each difference.
  [[nodiscard]] const std::vector<std::string>& differences() const noexcept { return differences_; }

 private:
  [[nodiscard]] const std::vector<std::string>& devices() const { return coordinator_.plan().devices; }
  [[nodiscard]] std::size_t wait_for_agreement() const;

  Operator& sender_;
  const model::Cell& cell_;
  Coordinator coordinator_;
  std::vector<std::string> differences_;
  std::vector<std::string> changing_;  // devices on which the update changes something
  std::int64_t t0_ns_ = 0;             // T0 of the deployment
  bool require_real_time_ = false;
};

Problems Update::compare(const std::string& text) {
  coordinator_.show_progress("comparing the running cell with the new descriptor on " + list_of(devices()));
  return coordinator_.prepare(text, [this](const std::string& device, const json& answer) {
    if (answer.value("change", "") != model::to_text(model::Change::none)) changing_.push_back(device);
    for (const std::string& line : answer.value("words", std::vector<std::string>{}))
      differences_.push_back(line);
    if (!answer.contains("t0_ns")) return;
    t0_ns_ = answer.at("t0_ns").get<std::int64_t>();
    require_real_time_ = answer.value("require_real_time", false);
  });
}

Problems Update::change() {
  coordinator_.show_progress("changing " + list_of(changing_));
  return coordinator_.change(t0_ns_, require_real_time_);
}

Updated Update::put_back(Problems problems) {
  const std::string name = "cell " + cell_.name + " is not updated; ";
  std::set<std::string> not_restored = coordinator_.not_restored();
  std::vector<CommandRequest> requests;
  for (const std::string& device : devices()) {
    // A device without a live node has nothing to undo, so it gets no command.
    if (!coordinator_.rejecting().contains(device) && coordinator_.is_alive(device))
      requests.push_back(coordinator_.request(COMMAND_PUT_BACK, device));
  }
  Coordinator::Answers answers = coordinator_.send(requests, false);
  bool undone = false;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const bool kept = answers[i] && answers[i]->head.value() == std::string{wire::kKept};
    const auto answer = accepted(std::move(answers[i]));
    undone |= answer.ok();
    if (answer || kept) continue;
    for (const Problem& problem : of_device(requests[i].device, answer.problems())) {
      if (std::find(problems.begin(), problems.end(), problem) == problems.end()) problems.push_back(problem);
    }
    not_restored.insert(requests[i].device);
  }
  const std::size_t final = coordinator_.run_sent() ? wait_for_agreement() : 0;
  if (final != 0) {
    const std::string later = final == devices().size() ? "" : "; not all devices have confirmed this yet";
    return {std::move(problems),
            "cell " + cell_.name + " is updated, because all devices had made their changes" + later};
  }
  const bool all_undone =
      coordinator_.run_sent() ? coordinator_.in_stage(STAGE_UNDONE) == devices().size() : undone;
  if (!all_undone)
    return {std::move(problems), "the devices decide together whether cell " + cell_.name +
                                     " is updated; takt status shows their decision"};
  if (!not_restored.empty())
    return {std::move(problems), name + "its changes could not be undone on " +
                                     list_of({not_restored.begin(), not_restored.end()}) +
                                     "; takt status shows the present state"};
  return {std::move(problems), name + "all changes were undone"};
}

// Waits until all devices have gone back, or all are final. Returns how many devices are final.
std::size_t Update::wait_for_agreement() const {
  sender_.observer().wait(
      [this](const auto&) {
        return coordinator_.in_stage(STAGE_UNDONE) == devices().size() ||
               coordinator_.in_stage(STAGE_FINAL) == devices().size();
      },
      kAgreed);
  return coordinator_.in_stage(STAGE_FINAL);
}

}  // namespace

Updated update(Operator& sender, const model::Cell& cell, const std::string& text,
               const UpdateOptions& options) {
  if (text.size() > wire::kMaxData)
    return {{fail("the descriptor is larger than " + std::to_string(wire::kMaxData >> 20U) + " MiB",
                  "make it smaller")},
            "nothing was changed"};
  const std::string unchanged = "cell " + cell.name + " is not updated; nothing was changed";
  const auto there = devices_of(sender, cell.name);
  if (!there) {
    Problem problem = there.problems()[0];
    problem.fix += (problem.fix.empty() ? "" : "; ") + std::string{"start the cell with takt deploy"};
    return {{problem}, unchanged};
  }
  Problems lost;
  for (const std::string& device : there->lost)
    lost.push_back({"device " + device, "it is not reached; an update needs all devices",
                    "start its node again with --resume, or undeploy the cell and deploy it again"});
  if (!lost.empty()) return {std::move(lost), unchanged};
  std::vector<std::string> devices = there->names;
  for (const std::string& device : model::device_names(cell)) {
    if (std::find(devices.begin(), devices.end(), device) == devices.end()) devices.push_back(device);
  }
  Update update{sender,
                cell,
                {.cell = cell,
                 .name = "update",
                 .id = new_id(),
                 .deployment = there->deployment,
                 .devices = std::move(devices),
                 .progress = options.progress,
                 .cancelled = options.cancelled}};
  if (Problems problems = update.compare(text); !problems.empty())
    return {update.put_back(std::move(problems)).problems, unchanged};
  if (update.differences().empty()) {
    static_cast<void>(update.put_back({}));
    return {{}, "nothing differs"};
  }
  if (options.differs) options.differs(update.differences());
  Problems problems = update.change();
  if (problems.empty()) problems = update.run();
  if (problems.empty()) return {{}, "cell " + cell.name + " is updated"};
  if (options.progress) options.progress("undoing the changes");
  return update.put_back(std::move(problems));
}

}  // namespace takt::client
