#include <takt/client/update.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
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
  /// Undoes the changes. `problems` says why.
  Updated put_back(Problems problems);
  [[nodiscard]] Problems failed_modules() const { return coordinator_.failed_modules(); }
  /// One line of text for each difference.
  [[nodiscard]] const std::vector<std::string>& differences() const noexcept { return differences_; }

 private:
  [[nodiscard]] const std::vector<std::string>& devices() const { return coordinator_.plan().devices; }
  /// Waits until the devices have decided, if they may have T0. Returns the outcome if any device is final,
  /// or if their decision is not known.
  [[nodiscard]] std::optional<Updated> decided(const Problems& problems) const;

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
  std::set<std::string> not_restored = coordinator_.not_restored();
  std::set<std::string> silent;
  std::vector<CommandRequest> requests;
  for (const std::string& device : devices()) {
    if (coordinator_.rejecting().contains(device)) continue;
    if (coordinator_.is_alive(device))
      requests.push_back(coordinator_.request(COMMAND_PUT_BACK, device));
    else
      silent.insert(device);
  }
  const Coordinator::Answers answers = coordinator_.send(requests, false);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const bool kept = answers[i] && answers[i]->head.value() == std::string{wire::kKept};
    const auto answer = accepted(answers[i]);
    if (kept) continue;
    // A device that has undone the update by itself says why.
    const bool says_why = answer && !answer->data.empty();
    const Problems more = says_why ? problems_of(*answer) : answer ? Problems{} : answer.problems();
    for (const Problem& problem : of_device(requests[i].device, more)) {
      if (std::find(problems.begin(), problems.end(), problem) == problems.end()) problems.push_back(problem);
    }
    if (answer) continue;
    (answers[i] ? not_restored : silent).insert(requests[i].device);
  }
  const std::string cell = "cell " + cell_.name;
  if (coordinator_.undeployed()) return {std::move(problems), cell + " was undeployed in the meantime"};
  if (coordinator_.run_sent()) {
    if (auto outcome = decided(problems)) return std::move(*outcome);
    silent.clear();
  }
  std::string outcome = cell + " is not updated; ";
  if (!not_restored.empty())
    outcome += "its changes could not be undone on " + list_of({not_restored.begin(), not_restored.end()}) +
               "; takt status shows the present state";
  else if (!silent.empty())
    outcome +=
        list_of({silent.begin(), silent.end()}) + (silent.size() == 1 ? " has" : " have") +
        " not confirmed this; a device that hears nothing from takt deploy undoes its changes by itself";
  else
    outcome += "all changes were undone";
  return {std::move(problems), outcome};
}

std::optional<Updated> Update::decided(const Problems& problems) const {
  const std::string cell = "cell " + cell_.name;
  coordinator_.show_progress("waiting for the decision of the devices");
  sender_.observer().wait(
      [this](const auto&) {
        return coordinator_.in_stage(STAGE_UNDONE).size() == devices().size() ||
               coordinator_.in_stage(STAGE_FINAL).size() == devices().size();
      },
      kAgreed);
  const std::set<std::string> final = coordinator_.in_stage(STAGE_FINAL);
  if (final.size() == devices().size()) return Updated{.outcome = cell + " is updated"};
  if (final.empty()) {
    if (coordinator_.in_stage(STAGE_UNDONE).size() == devices().size()) return std::nullopt;
    return Updated{.problems = problems,
                   .outcome = "the devices decide together whether " + cell +
                              " is updated; takt status shows their decision"};
  }
  Updated updated{.outcome = cell +
                             " is updated, because all devices had made their changes; not all devices "
                             "have confirmed this yet"};
  for (const std::string& device : devices()) {
    if (final.contains(device)) continue;
    const auto seen = sender_.observer().devices(device);
    const bool is_free = std::any_of(seen.begin(), seen.end(), [](const wire::ObservedDevice& one) {
      return one.alive && one.status.deployment().size() == 0;
    });
    updated.problems.push_back({"device " + device,
                                !coordinator_.is_alive(device) ? "it is lost"
                                : is_free ? "its node was restarted without --resume, so it has no deployment"
                                          : "it has not confirmed the update yet",
                                is_free ? "run takt deploy --update again"
                                        : "it follows the others as soon as it is in contact with them"});
  }
  return updated;
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
    return {.outcome = "nothing differs", .failed_modules = update.failed_modules()};
  }
  if (options.differs) options.differs(update.differences());
  Problems problems = update.change();
  if (problems.empty()) problems = update.run();
  Updated updated{.outcome = "cell " + cell.name + " is updated"};
  if (!problems.empty()) {
    if (options.progress) options.progress("undoing the changes");
    updated = update.put_back(std::move(problems));
  }
  if (updated.problems.empty()) updated.failed_modules = update.failed_modules();
  return updated;
}

}  // namespace takt::client
