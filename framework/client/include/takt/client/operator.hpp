// Sends commands and questions to nodes, and waits for their answers.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/client/observer.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/dds/commands.hpp>

namespace takt::client {

struct Question {
  CommandKind kind = COMMAND_REPORT;
  std::string device;
  std::string module{};  ///< empty if the command concerns the whole device
  std::string deployment{};
  std::string property{};
  std::string value{};
  std::string data{};
  std::int64_t time_ns = 0;
  /// How long to wait for the answer once the device is found. The search for the device also takes at most
  /// this time, and never longer than Operator::search_limit(). The default is 5 s, because a lost discovery
  /// message can delay the answer by 2.4 s. Without a value, ask() waits until the device answers or is lost.
  /// This is for commands that may take long, for example because a component initialises.
  std::optional<Nanoseconds> limit = std::chrono::seconds{5};
  std::int32_t process_id = 0;  ///< send only to the node with this process id; 0 for any node of the device
};

/// Sends questions and commands to nodes. Any thread may call it.
class Operator {
 public:
  /// Creates an operator. The observer must outlive it. `domain` is used only in error messages.
  static Result<std::unique_ptr<Operator>> create(std::shared_ptr<dds::Participant> participant,
                                                  const Observer& observer, int domain);
  ~Operator();

  /// Sends a question and returns the node's answer. An answer with an error code, such as REPLY_REFUSED, is
  /// returned, too. Fails if the device is not found, if two nodes have its name, if it is lost, or if it
  /// does not answer in time.
  Result<wire::WholeReply> ask(const Question& question);
  /// Sends all questions in parallel and returns the answers in the order of the questions. Calls `give_up`
  /// repeatedly; when it returns true, ends the wait for the remaining answers.
  std::vector<Result<wire::WholeReply>> ask(const std::vector<Question>& questions,
                                           const std::function<bool()>& give_up = {});

  [[nodiscard]] const Observer& observer() const noexcept { return observer_; }
  [[nodiscard]] int domain() const noexcept { return domain_; }
  /// How long to search for a node. This is 3 s, or 10 s with DDS Security, because a busy machine takes
  /// several seconds to authenticate a participant.
  [[nodiscard]] Nanoseconds search_limit() const noexcept { return search_limit_; }

 private:
  struct Inside;
  Operator(std::unique_ptr<Inside> inside, const Observer& observer, int domain, Nanoseconds search_limit);

  std::unique_ptr<Inside> inside_;
  const Observer& observer_;
  int domain_;
  Nanoseconds search_limit_;
};

/// Returns the problems that the data of an answer lists. If it lists none, returns the text of the answer as
/// the only problem.
Problems problems_of(const wire::WholeReply& reply);

/// Returns the answer if its code is REPLY_OK. Otherwise returns the problems of the answer, or the reason
/// why there is no answer.
Result<wire::WholeReply> accepted(Result<wire::WholeReply> answer);

}  // namespace takt::client
