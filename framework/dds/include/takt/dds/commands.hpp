// Requests and their answers: takt/command and takt/reply, reliable, volatile, keep last 32. Data longer than
// one sample travels in parts and is put together here.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <takt/wire/takt.h>
#include <takt/core/result.hpp>
#include <takt/dds/assembly.hpp>
#include <takt/dds/participant.hpp>

namespace takt::dds {

/// A command or reply whose data is whole, of any length up to kMaxData.
struct WholeCommand {
  Command head;  ///< part, parts and data are not used
  std::string data;
};
struct WholeReply {
  Reply head;
  std::string data;
};

/// A node's end.
class CommandServer {
 public:
  /// `handle` is called once for each command id that names `device` (and this node, if it names one), on a
  /// thread of its own that is neither real-time nor one of Fast DDS, in the order of arrival. A repeated id
  /// is answered again by what reply() said, without a call. At most 256 commands and 64 MiB wait for an
  /// answer at a time; more are left for their askers to send again.
  static Result<CommandServer> create(std::shared_ptr<Participant> participant, std::string device,
                                      std::string node, std::function<void(const WholeCommand&)> handle);
  CommandServer(CommandServer&&) noexcept;
  CommandServer& operator=(CommandServer&&) noexcept;
  ~CommandServer();

  /// From any thread, at once or much later. Sent once the asker's reader has matched, so that no first
  /// answer is lost. Kept for repeated ids (the last 256).
  void reply(const WholeReply& reply);

  /// Samples that came and were no command, or made no sense. Whoever sent them gets no answer.
  [[nodiscard]] std::uint64_t refused() const;

 private:
  struct Inside;
  explicit CommandServer(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

/// The asker's end.
class CommandClient {
 public:
  /// `heard` gets every reply to a command of this client, on a thread of Fast DDS.
  static Result<CommandClient> create(std::shared_ptr<Participant> participant,
                                      std::function<void(const WholeReply&)> heard);
  CommandClient(CommandClient&&) noexcept;
  CommandClient& operator=(CommandClient&&) noexcept;
  ~CommandClient();

  /// Sends it (head.id is given by the caller, and no other on the domain has it) once the command reader of
  /// a node has matched, and again each second and whenever another has matched, until an answer came or it
  /// is forgotten: an answer may well come after head.deadline_ns, until which it is to be begun; for the
  /// first time it is never sent after that. One answer is heard for each id. False where the data is longer
  /// than kMaxData.
  bool send(const WholeCommand& command);
  /// Nobody waits for an answer to it any more.
  void forget(const std::string& id);

 private:
  struct Inside;
  explicit CommandClient(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::dds
