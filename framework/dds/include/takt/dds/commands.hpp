// Sends and receives commands and their replies. The QoS of the topics takt/command and takt/reply is
// reliable, volatile, keep last 32. Data that is too long for one sample is sent in parts, which the receiver
// assembles.
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

/// Receives commands and sends replies; used in a node.
class CommandServer {
 public:
  /// Calls `handle` for each command that names `device` and either this node or no node, in the order of
  /// arrival. The calls come from a thread of the server that is not real-time. If a client repeats a command
  /// with the same id, the server sends the first reply again and does not call `handle`. At most 256
  /// commands with at most 64 MiB of data may be unanswered. The server drops further commands, and their
  /// clients send them again.
  static Result<CommandServer> create(std::shared_ptr<Participant> participant, std::string device,
                                      std::string node, std::function<void(const wire::WholeCommand&)> handle);
  CommandServer(CommandServer&&) noexcept;
  CommandServer& operator=(CommandServer&&) noexcept;
  ~CommandServer();

  /// Replies to a command. Any thread may call this, at any time after the command. The server sends the
  /// reply when the client's reader has matched, so that the first reply is not lost. It keeps the latest
  /// replies, at most 256 with at most 64 MiB, for repeated commands.
  void reply(const wire::WholeReply& reply);

  /// Returns how many samples were dropped because they were invalid or exceeded the rate limit. Their
  /// senders get no reply.
  [[nodiscard]] std::uint64_t refused() const;

 private:
  struct Inside;
  explicit CommandServer(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

/// Sends commands and receives replies; used in a client.
class CommandClient {
 public:
  /// Calls `heard` with the reply to each command of this client, on a thread of Fast DDS.
  static Result<CommandClient> create(std::shared_ptr<Participant> participant,
                                      std::function<void(const wire::WholeReply&)> heard);
  CommandClient(CommandClient&&) noexcept;
  CommandClient& operator=(CommandClient&&) noexcept;
  ~CommandClient();

  /// Sends a command as soon as the command reader of a node has matched. Repeats it each second, and
  /// whenever another reader matches, until a reply arrives or forget() is called. The caller chooses
  /// head.id, which must be unique on the domain. The node must begin to execute the command by
  /// head.deadline_ns. After this time, the client repeats the command only if it was sent before, because
  /// the reply may still arrive. `heard` gets at most one reply for each id. Returns false if the data is
  /// longer than wire::kMaxData.
  bool send(const wire::WholeCommand& command);
  /// Stops repeating a command and ignores its reply.
  void forget(const std::string& id);

 private:
  struct Inside;
  explicit CommandClient(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::dds
