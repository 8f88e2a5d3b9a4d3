// Sends and receives commands and their replies. The QoS of the topics takt/command and takt/reply is
// reliable, volatile, keep last 128. Data that is too long for one sample is sent in parts, which the receiver
// assembles.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <takt/wire/takt.h>
#include <takt/core/result.hpp>
#include <takt/dds/participant.hpp>
#include <takt/wire/assembly.hpp>

namespace takt::dds {

/// Receives commands and sends replies; used in a node.
class CommandServer {
 public:
  /// Creates a server. The server calls `handle` for each command that names `device` and either this node or
  /// no node, in the order of arrival. These calls come from a thread of the server that is not real-time. If
  /// a client repeats a command with the same id, the server sends the first reply again and does not call
  /// `handle`. At most 256 commands, with at most 64 MiB of data in total, may be unanswered. The server
  /// drops further commands, and their clients send them again.
  static Result<CommandServer> create(std::shared_ptr<Participant> participant, std::string device,
                                      std::string node,
                                      std::function<void(const wire::WholeCommand&)> handle);
  CommandServer(CommandServer&&) noexcept;
  CommandServer& operator=(CommandServer&&) noexcept;
  ~CommandServer();

  /// Replies to a command. Any thread may call reply(), at any time after the command has arrived. The server
  /// sends the reply when the client's reader has matched, so that the first reply is not lost. To answer
  /// repeated commands, the server keeps the latest replies: at most 256, with at most 64 MiB in total.
  void reply(const wire::WholeReply& reply);

  /// Returns the number of samples that were dropped because they were invalid or exceeded the rate limit.
  /// The senders of these samples get no reply.
  [[nodiscard]] std::uint64_t refused() const;

 private:
  struct Inside;
  explicit CommandServer(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

/// Sends commands and receives replies; used in a client.
class CommandClient {
 public:
  /// Creates a client. A thread of Fast DDS calls `on_reply` with the reply to each command of this client.
  static Result<CommandClient> create(std::shared_ptr<Participant> participant,
                                      std::function<void(const wire::WholeReply&)> on_reply);
  CommandClient(CommandClient&&) noexcept;
  CommandClient& operator=(CommandClient&&) noexcept;
  ~CommandClient();

  /// Sends a command as soon as the command reader of a node has matched. Repeats the command each second,
  /// and whenever the command reader of a further node matches, until a reply arrives or forget() is called.
  /// The caller chooses head.id, which must be unique on the domain. The node must begin to execute the
  /// command by head.deadline_ns. After this time, the client repeats the command only if it sent the command
  /// before this time, because a reply may still arrive. `on_reply` gets at most one reply for each id.
  /// Returns false if the data is longer than wire::kMaxData.
  bool send(const wire::WholeCommand& command);
  /// Returns how often the command with this id has been sent; 0 if its reply has arrived.
  [[nodiscard]] int sent(const std::string& id) const;
  /// Returns true if the command's deadline passed before it was sent the first time, for example because
  /// this process was halted. Then the command is forgotten and will never be sent.
  bool is_too_late(const std::string& id);
  /// Stops repeating a command and ignores its reply.
  void forget(const std::string& id);

 private:
  struct Inside;
  explicit CommandClient(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::dds
