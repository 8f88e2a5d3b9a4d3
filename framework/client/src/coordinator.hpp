// Leads the devices of a cell through a deployment or an update.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::client {

/// What a coordinator needs to know about its deployment or update.
struct Plan {
  const model::Cell& cell;                            ///< the new cell
  std::string name;                                   ///< "deployment" or "update"
  std::string id;                                     ///< id of the deployment or update
  std::string deployment;                             ///< id of the cell's deployment
  std::vector<std::string> devices;                   ///< all devices that take part
  std::map<std::string, std::int32_t> process_ids{};  ///< see DeployOptions
  std::function<void(const std::string&)> progress{};
  std::function<bool()> cancelled{};
};

/// Sends the devices each command when all of them have answered the command before, and finally T0. The
/// devices then decide together.
class Coordinator {
 public:
  using Answers = std::vector<Result<wire::WholeReply>>;

  Coordinator(Operator& sender, Plan plan) : sender_(sender), plan_(std::move(plan)) {}

  [[nodiscard]] const Plan& plan() const noexcept { return plan_; }
  [[nodiscard]] Operator& sender() const noexcept { return sender_; }
  /// True if the devices may have begun to make their changes.
  [[nodiscard]] bool change_sent() const noexcept { return change_sent_; }
  /// True if the devices may have received T0. From then on, they decide together.
  [[nodiscard]] bool run_sent() const noexcept { return run_sent_; }
  /// T0 on the wall clock, in ns since 1970.
  [[nodiscard]] std::int64_t t0_ns() const noexcept { return t0_ns_; }
  [[nodiscard]] bool cancelled() const { return plan_.cancelled && plan_.cancelled(); }
  void show_progress(const std::string& text) const {
    if (plan_.progress) plan_.progress(text);
  }

  /// Lets each device check the descriptor and its components, and then checks the connections between the
  /// devices. `text` is the descriptor from which the cell was read. Calls `read` with each answer, which is
  /// a JSON object.
  Problems prepare(const std::string& text,
                   const std::function<void(const std::string&, const nlohmann::ordered_json&)>& read = {});
  /// Lets each device make its changes. `t0_ns` is the time from which releases are counted; 0: from T0.
  Problems change(std::int64_t t0_ns, bool require_real_time);
  /// The devices that have rejected the descriptor, so they have nothing to undo.
  [[nodiscard]] const std::set<std::string>& rejecting() const noexcept { return rejecting_; }
  /// True if a device has said that another operator has undeployed the cell.
  [[nodiscard]] bool undeployed() const noexcept { return undeployed_; }
  /// Returns the modules that have failed. Waits a moment for the first run of each module.
  [[nodiscard]] Problems failed_modules() const;
  /// The devices that could neither make nor undo their changes.
  [[nodiscard]] const std::set<std::string>& not_restored() const noexcept { return not_restored_; }
  /// Returns a command to a device. By default, the device may take as long for it as it needs.
  [[nodiscard]] CommandRequest request(CommandKind kind, const std::string& device) const;
  /// Sends the commands and returns the answers in the order of the requests. Keeps the devices from undoing
  /// everything in the meantime.
  Answers send(const std::vector<CommandRequest>& requests, bool may_be_cancelled = true);
  /// Sends the devices T0, and waits until each of them is final. Returns the reasons why one is not.
  Problems run();
  /// Returns true if the device has a live node.
  [[nodiscard]] bool is_alive(const std::string& device) const;
  /// Returns the devices that are known to be in this stage of the deployment or update.
  [[nodiscard]] std::set<std::string> in_stage(TransactionStage stage) const;

 private:
  /// Returns a command to each device.
  [[nodiscard]] std::vector<CommandRequest> requests(CommandKind kind) const;
  /// Returns the problems in the answers, each problem only once, because several devices may report the same
  /// problem of the whole cell; or only that the user has cancelled.
  [[nodiscard]] Problems problems_in(const std::vector<CommandRequest>& requests, const Answers& answers);
  /// Returns a problem if this program has lost all of several devices, because then its own network is
  /// likely to be the cause.
  [[nodiscard]] std::optional<Problem> cut_off() const;
  enum class Stands { final, undone, undecided, lost };
  [[nodiscard]] Stands stands(const std::vector<wire::ObservedDevice>& seen, const std::string& device) const;
  [[nodiscard]] Problems decided() const;
  [[nodiscard]] Problems cancelled_problem() const;
  void keep_alive();

  Operator& sender_;
  Plan plan_;
  std::set<std::string> rejecting_;
  std::set<std::string> not_restored_;
  std::string safe_;  // safe values of all outputs of the cell, as JSON; each device gets all values, because
                      // it knows only its own
  std::chrono::steady_clock::time_point sent_at_{};
  bool change_sent_ = false;
  bool run_sent_ = false;
  bool undeployed_ = false;
  std::int64_t t0_ns_ = 0;
};

}  // namespace takt::client
