// Commands and their replies. The topics takt/command and takt/reply are reliable, volatile and keep last 32.
// Data that is longer than one sample is sent in parts and assembled here.
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

/// Receives commands and sends replies, in a node.
class CommandServer {
 public:
  /// `handle` is called for each command that names `device` and either this node or no node, in the order of
  /// arrival. The calling thread is neither real-time nor one of Fast DDS. If a command is repeated with the
  /// same id, the first reply is sent again without another call. At most 256 commands and 64 MiB wait for a
  /// reply at a time; further commands are dropped, and their clients send them again.
  static Result<CommandServer> create(std::shared_ptr<Participant> participant, std::string device,
                                      std::string node, std::function<void(const wire::WholeCommand&)> handle);
  CommandServer(CommandServer&&) noexcept;
  CommandServer& operator=(CommandServer&&) noexcept;
  ~CommandServer();

  /// Replies to a command. May be called on any thread, at once or much later. The reply is sent once the
  /// client's reader has matched, so the first reply is not lost. The last replies, at most 256 and 64 MiB,
  /// are kept for repeated commands.
  void reply(const wire::WholeReply& reply);

  /// The number of samples that were dropped because they were invalid or exceeded the rate limit. Their
  /// senders get no reply.
  [[nodiscard]] std::uint64_t refused() const;

 private:
  struct Inside;
  explicit CommandServer(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

/// Sends commands and receives replies, in a client.
class CommandClient {
 public:
  /// `heard` receives the reply to each command of this client, on a thread of Fast DDS.
  static Result<CommandClient> create(std::shared_ptr<Participant> participant,
                                      std::function<void(const wire::WholeReply&)> heard);
  CommandClient(CommandClient&&) noexcept;
  CommandClient& operator=(CommandClient&&) noexcept;
  ~CommandClient();

  /// Sends a command once the command reader of a node has matched. Repeats it each second, and whenever
  /// another reader matches, until a reply arrives or forget() is called. The caller chooses head.id, which
  /// must be unique on the domain. The node must begin the command by head.deadline_ns. After this time, only
  /// a command that was already sent is repeated, because its reply may still arrive. Each id gets one reply.
  /// Returns false if the data is longer than wire::kMaxData.
  bool send(const wire::WholeCommand& command);
  /// Stops waiting for the reply to a command.
  void forget(const std::string& id);

 private:
  struct Inside;
  explicit CommandClient(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::dds
