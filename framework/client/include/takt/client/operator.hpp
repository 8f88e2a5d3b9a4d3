// Asks nodes to do something, and waits for their answers.
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
  /// How long the answer is waited for once the device is found, which is looked for no longer than that, and
  /// never longer than 3 s. Discovery may take 2.4 s to let the answer through where a message of it is lost,
  /// hence 5. None: it takes as long as it takes (a component is initialised); only the end of the device
  /// ends the wait.
  std::optional<Nanoseconds> limit = std::chrono::seconds{5};
  std::int32_t process_id = 0;  ///< of the only node that is meant; 0: the one of that name
};

/// One who asks. Any thread.
class Operator {
 public:
  /// The participant and the observer outlive it. `domain` is named in messages.
  static Result<std::unique_ptr<Operator>> create(std::shared_ptr<dds::Participant> participant,
                                                  const Observer& observer, int domain);
  ~Operator();

  /// The node's answer, whatever it is: REPLY_REFUSED is one. Fails where there is none: the device is not
  /// there, there are two of its name, it was lost meanwhile, or it said nothing in time.
  Result<dds::WholeReply> ask(const Question& question);
  /// The same for several at once, each answer at its question's place. With `give_up` returning true those
  /// that have not answered yet are not waited for any more.
  std::vector<Result<dds::WholeReply>> ask(const std::vector<Question>& questions,
                                           const std::function<bool()>& give_up = {});

  [[nodiscard]] const Observer& observer() const noexcept { return observer_; }
  [[nodiscard]] int domain() const noexcept { return domain_; }

 private:
  struct Inside;
  Operator(std::unique_ptr<Inside> inside, const Observer& observer, int domain);

  std::unique_ptr<Inside> inside_;
  const Observer& observer_;
  int domain_;
};

/// What an answer complains of: every reason that it carries, or its text.
Problems problems_of(const dds::WholeReply& reply);

/// The answer of a device that is asked, or why there is none or why it is not "ok".
Result<dds::WholeReply> accepted(Result<dds::WholeReply> answer);

}  // namespace takt::client
