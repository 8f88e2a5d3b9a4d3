// The DDS participant of a process. It uses only UDPv4.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/security/identity.hpp>

namespace takt::dds {

struct ParticipantOptions {
  std::string name;                     ///< for humans; visible on the network
  int domain = 0;                       ///< 0 to 232
  model::Discovery discovery;           ///< multicast by default
  std::vector<std::string> interfaces;  ///< IPv4 addresses of the interfaces to use; empty for all
  std::string security{};               ///< the folder of an identity; empty for no DDS Security
  /// Receives a sentence about each rejected participant or packet. Each sentence is reported once, and at
  /// most ten per minute. The function is called on threads of Fast DDS, so it must be quick. It may be
  /// empty.
  std::function<void(const std::string&)> refused{};
};

/// All topics of a process belong to one participant, because several participants in one process deadlock in
/// this version of Fast DDS. Its threads inherit the scheduling policy and CPUs of the thread that creates
/// it. The last owner of the participant must release it before main() returns; this deletes everything that
/// it created.
class Participant {
 public:
  /// Fails if the domain or an address cannot be used, if the process already has a participant, or if the
  /// calling thread is real-time. With security it also fails if security::read_identity() rejects the
  /// identity, if the identity is not for this domain, or if a discovery server is configured.
  static Result<std::shared_ptr<Participant>> create(const ParticipantOptions& options);
  virtual ~Participant() = default;

  /// Starts to use network interfaces that have come up since the last call. The call is cheap; make it now
  /// and then. If only the loopback interface existed before, as on a starting machine, every reader and
  /// writer is recreated, and programs on this machine lose them for a moment. Otherwise only new readers and
  /// writers use the new interfaces; existing connections keep their addresses.
  virtual void rescan_interfaces() = 0;

  /// The identity of this process; empty without DDS Security.
  [[nodiscard]] virtual const std::optional<security::Identity>& identity() const noexcept = 0;
  /// The number of packets that the filter dropped before Fast DDS saw them.
  [[nodiscard]] virtual std::uint64_t refused() const noexcept = 0;

 protected:
  Participant() = default;
};

}  // namespace takt::dds
