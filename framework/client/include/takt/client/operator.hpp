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
  std::string module{};  ///< empty: the whole device
  std::string deployment{};
  std::string property{};
  std::string value{};
  std::string data{};
  std::int64_t time_ns = 0;
  /// How long to wait for the answer once the device is found. The search takes at most as long, and never
  /// longer than Operator::search_limit(). The default is 5 s because discovery may hold the answer back for 2.4 s when one of
  /// its messages is lost. None: waits until the device answers (initialising a component can take long) or
  /// is lost.
  std::optional<Nanoseconds> limit = std::chrono::seconds{5};
  std::int32_t process_id = 0;  ///< only the node with this process id; 0: the node of that name
};

/// Asks nodes on behalf of one program. Any thread.
class Operator {
 public:
  /// The participant and the observer must outlive it. `domain` appears in messages.
  static Result<std::unique_ptr<Operator>> create(std::shared_ptr<dds::Participant> participant,
                                                  const Observer& observer, int domain);
  ~Operator();

  /// The node's answer, whatever its code: REPLY_REFUSED is an answer too. Fails if there is none: the device
  /// is not found, two devices have its name, it is lost, or it does not answer in time.
  Result<wire::WholeReply> ask(const Question& question);
  /// Asks all questions at the same time and returns the answers in the order of the questions. `give_up` is
  /// polled; when it returns true, the wait for the remaining answers ends.
  std::vector<Result<wire::WholeReply>> ask(const std::vector<Question>& questions,
                                           const std::function<bool()>& give_up = {});

  [[nodiscard]] const Observer& observer() const noexcept { return observer_; }
  [[nodiscard]] int domain() const noexcept { return domain_; }
  /// How long to search for a node: 3 s, or 10 s with DDS Security, where a busy machine takes several seconds
  /// to authenticate a participant.
  [[nodiscard]] Nanoseconds search_limit() const noexcept { return search_limit_; }

 private:
  struct Inside;
  Operator(std::unique_ptr<Inside> inside, const Observer& observer, int domain, Nanoseconds search_limit);

  std::unique_ptr<Inside> inside_;
  const Observer& observer_;
  int domain_;
  Nanoseconds search_limit_;
};

/// The problems that an answer carries as data, or else its text.
Problems problems_of(const wire::WholeReply& reply);

/// The answer if its code is REPLY_OK; otherwise its problems, or why there is no answer.
Result<wire::WholeReply> accepted(Result<wire::WholeReply> answer);

}  // namespace takt::client
