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
  model::Discovery discovery;           ///< by default multicast
  std::vector<std::string> interfaces;  ///< IPv4 addresses of the interfaces to use; empty: all
  std::string security{};               ///< the folder of an identity; empty: without DDS Security
  /// Receives a sentence about each rejected participant or packet: each text once, at most ten per minute.
  /// Called on threads of Fast DDS, so it must be quick. May be empty.
  std::function<void(const std::string&)> refused{};
};

/// All topics of a process belong to one participant; several participants in one process deadlock in this
/// version of Fast DDS. Its threads inherit the scheduling policy and CPUs of the creating thread. The last
/// owner deletes it with everything that it created, and must do so before main() returns.
class Participant {
 public:
  /// Fails if the domain or an address cannot be used, if the process already has a participant, and on a
  /// real-time thread. With security it also fails if security::read_identity() rejects the identity, if the
  /// identity is not for this domain, and with a discovery server.
  static Result<std::shared_ptr<Participant>> create(const ParticipantOptions& options);
  virtual ~Participant() = default;

  /// Starts to use interfaces that have come up since. Cheap; call it now and then. If only the loopback
  /// interface existed before, as on a starting machine, every reader and writer is recreated, and programs
  /// on this machine lose them for a moment. Interfaces that come up later are used for new readers and
  /// writers; existing connections keep their addresses.
  virtual void rescan_interfaces() = 0;

  /// The identity of this process; none without DDS Security.
  [[nodiscard]] virtual const std::optional<security::Identity>& identity() const noexcept = 0;
  /// The number of packets that the filter dropped before Fast DDS saw them.
  [[nodiscard]] virtual std::uint64_t refused() const noexcept = 0;

 protected:
  Participant() = default;
};

}  // namespace takt::dds
