// Commands and their replies: topics takt/command and takt/reply, reliable, volatile, keep last 32. Data that
// is longer than one sample travels in parts and is assembled here.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <takt/wire/takt.h>
#include <takt/core/result.hpp>
#include <takt/wire/assembly.hpp>
#include <takt/dds/participant.hpp>

namespace takt::dds {

/// The node's side.
class CommandServer {
 public:
  /// `handle` is called once for each command id that names `device` (and this node, if it names one), in the
  /// order of arrival. The calling thread is neither real-time nor one of Fast DDS. A repeated id gets the
  /// same answer again, without a call. At most 256 commands and 64 MiB wait for an answer at a time; the
  /// others are dropped, and their clients send them again.
  static Result<CommandServer> create(std::shared_ptr<Participant> participant, std::string device,
                                      std::string node, std::function<void(const wire::WholeCommand&)> handle);
  CommandServer(CommandServer&&) noexcept;
  CommandServer& operator=(CommandServer&&) noexcept;
  ~CommandServer();

  /// Call it from any thread, at once or much later. The reply is sent once the client's reader has matched,
  /// so the first reply is not lost. The last 256 replies are kept for repeated ids.
  void reply(const wire::WholeReply& reply);

  /// The number of samples that were not valid commands. Their senders get no answer.
  [[nodiscard]] std::uint64_t refused() const;

 private:
  struct Inside;
  explicit CommandServer(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

/// The client's side.
class CommandClient {
 public:
  /// `heard` gets every reply to a command of this client, on a thread of Fast DDS.
  static Result<CommandClient> create(std::shared_ptr<Participant> participant,
                                      std::function<void(const wire::WholeReply&)> heard);
  CommandClient(CommandClient&&) noexcept;
  CommandClient& operator=(CommandClient&&) noexcept;
  ~CommandClient();

  /// Sends a command once the command reader of a node has matched. Repeats it each second, and whenever
  /// another reader matches, until an answer arrives or forget() is called. The caller chooses head.id, which
  /// must be unique on the domain. The node must begin the command by head.deadline_ns; after that the
  /// command is not sent for the first time, but the answer may arrive later. Each id gets one answer.
  /// Returns false if the data is longer than wire::kMaxData.
  bool send(const wire::WholeCommand& command);
  /// Stops waiting for the answer to a command.
  void forget(const std::string& id);

 private:
  struct Inside;
  explicit CommandClient(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::dds
