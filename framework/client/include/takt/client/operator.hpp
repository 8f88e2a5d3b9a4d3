// Sends commands to nodes, and waits for their answers.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <takt/client/observer.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/dds/commands.hpp>

namespace takt::client {

/// The longest time that send() waits for the answer to a command without a time limit of its own. A node
/// limits the duration of each hook and each step of a deployment. So a device that has not answered after
/// this time will not answer at all.
inline constexpr Nanoseconds kLongestCommand = std::chrono::minutes{2};

/// The longest search for a node over a slow link; see Operator::search().
inline constexpr Nanoseconds kSlowestSearch = std::chrono::seconds{20};

/// A command to a node, and the time limit for the node's answer.
struct CommandRequest {
  CommandKind kind = COMMAND_REPORT;
  std::string device;
  std::string module{};  ///< empty if the command concerns the whole device
  std::string deployment{};
  std::string property{};
  std::string value{};
  std::string data{};
  std::int64_t time_ns = 0;
  /// The longest time that send() waits for the answer after it has found the device. The search for the
  /// device takes at most this time, too, and only over a slow link longer than Operator::search_limit(). The
  /// default is 5 s, because a network that loses packets can delay the answer by 2 s. Without a value,
  /// send() waits kLongestCommand; use no value for commands that may take long, for example because a
  /// component initialises.
  std::optional<Nanoseconds> limit = std::chrono::seconds{5};
  std::int32_t process_id = 0;  ///< send only to the node with this process id; 0: to any node of the device
  std::string node{};           ///< send only to the node with this id; empty: to any node of the device
};

/// Fails if the request cannot be sent as it is: a name is not valid, or a name or the value is longer than
/// takt::Command allows. Operator::send() rejects such a request.
Result<void> check(const CommandRequest& request);

/// Sends commands to nodes. Any thread may call its functions.
class Operator {
 public:
  /// Creates an operator. The observer must outlive the operator. `domain`, and `node_options` with which a
  /// node is found, are used only in error messages. `progress` is called with a line of text that says for
  /// what a search waits longer than search_limit(); it may be empty.
  static Result<std::unique_ptr<Operator>> create(std::shared_ptr<dds::Participant> participant,
                                                  const Observer& observer, int domain,
                                                  std::string node_options,
                                                  std::function<void(const std::string&)> progress = {});
  ~Operator();

  /// Sends a command and returns the node's answer, even if the answer has an error code, such as
  /// REPLY_REFUSED. Fails if the device is not found, is lost or does not answer in time, or if two nodes
  /// have the device's name and the request selects neither.
  Result<wire::WholeReply> send(const CommandRequest& request);
  /// Sends all commands in parallel and returns the answers in the order of the requests. Calls `give_up`
  /// repeatedly. When `give_up` returns true, stops waiting, and returns a problem for each missing answer.
  std::vector<Result<wire::WholeReply>> send(const std::vector<CommandRequest>& requests,
                                             const std::function<bool()>& give_up = {});

  /// Waits like Observer::wait() for what the caller searches. Over a slow link, the search takes longer than
  /// `limit`: it goes on while discovery messages arrive from a node whose status has not arrived yet, but
  /// for at most kSlowestSearch. If `wanted` names devices, only their nodes count.
  bool search(const std::function<bool(const std::vector<wire::ObservedDevice>&)>& condition,
              Nanoseconds limit, const std::set<std::string>& wanted = {}) const;

  /// Returns the problem that a device of a running cell is lost. `why`: what other devices say about it.
  [[nodiscard]] Problem lost(const std::string& device, std::string why = {}) const;
  /// Returns the problem that a device was not found within this time.
  [[nodiscard]] Problem not_found(const std::string& device, Nanoseconds within) const;

  /// Returns the devices whose nodes have announced themselves, but whose status has not arrived. The value
  /// is true if other packets than announcements arrive from the node.
  [[nodiscard]] std::map<std::string, bool> silent() const;
  /// Says what to do about such devices.
  static std::string remedy_of_silence(const std::map<std::string, bool>& devices);
  /// Says what to do about this device if it is silent; otherwise the text is empty.
  [[nodiscard]] std::string remedy_of_silence(const std::string& device) const;

  [[nodiscard]] const Observer& observer() const noexcept { return observer_; }
  [[nodiscard]] int domain() const noexcept { return domain_; }
  /// The command that starts the node of a device so that this operator finds it.
  [[nodiscard]] std::string node_command(const std::string& device) const {
    return "takt-node --device " + device + " " + node_options_;
  }
  /// Returns a text about each peer or discovery server whose name cannot be resolved; empty if there is
  /// none.
  [[nodiscard]] std::string unresolved() const;
  /// The longest time of the search for a node: 3 s, or 10 s with DDS Security, because a busy machine takes
  /// several seconds to authenticate a participant.
  [[nodiscard]] Nanoseconds search_limit() const noexcept { return search_limit_; }

 private:
  struct Inside;
  Operator(std::unique_ptr<Inside> inside, const Observer& observer, int domain, std::string node_options,
           Nanoseconds search_limit);
  /// Returns true if packets arrive from the device's node, whether or not its status arrives.
  [[nodiscard]] bool sends(const std::string& device) const;
  /// Returns the names of the wanted devices, or of any devices, whose nodes are being matched, as a list.
  [[nodiscard]] std::string matching(const std::set<std::string>& wanted) const;

  std::unique_ptr<Inside> inside_;
  const Observer& observer_;
  int domain_;
  std::string node_options_;
  Nanoseconds search_limit_;
};

/// Returns the problems that the data of an answer lists. If it lists none, returns the text of the answer as
/// the only problem.
Problems problems_of(const wire::WholeReply& reply);

/// Returns the answer if its code is REPLY_OK. Otherwise fails with the problems of the answer or, if there
/// is no answer, with the reason why there is none.
Result<wire::WholeReply> accepted(Result<wire::WholeReply> answer);

}  // namespace takt::client
