// The DDS participant of a process. The participant communicates only over UDPv4.
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
  std::string name;            ///< name for diagnostics; other participants see it
  int domain = 0;              ///< 0 to 232
  model::Discovery discovery;  ///< how participants find each other; by default with multicast
  std::vector<std::string>
      interfaces;          ///< IPv4 addresses to use, besides the loopback interface; empty for all
  std::string security{};  ///< an identity folder; if empty, DDS Security is off
  /// Called with a sentence about each rejected participant or packet: the same sentence only once, and at
  /// most ten sentences per minute. Threads of Fast DDS call this function, so it must return quickly. The
  /// function may be empty.
  std::function<void(const std::string&)> refused{};
  /// Called with a sentence about each peer or discovery server whose name cannot be resolved yet, and when
  /// its addresses are known or have changed. A thread of the participant calls this function. It may be
  /// empty.
  std::function<void(const std::string&)> told{};
  /// Called like `refused` with a sentence about each participant that answers, but that longer packets do
  /// not reach. The function may be empty.
  std::function<void(const std::string&)> unreached{};
};

/// All topics of a process belong to one participant, because several participants in one process can
/// deadlock in Fast DDS 2.9.1. The participant's threads inherit the scheduling policy and CPUs of the thread
/// that creates the participant. The participant follows the machine's network interfaces: an interface or an
/// address that appears is used, and if one disappears that other machines use, the participant leaves the
/// domain and joins it again on the remaining ones. Processes on one machine communicate over its loopback
/// interface in any case. Names of peers and of a discovery server are looked up again and again: a name need
/// not be known when the participant is created, and its address may change. The last owner of the
/// participant must release it before main() returns. The destructor also deletes all DDS objects of the
/// participant.
class Participant {
 public:
  /// A participant whose announcements have arrived.
  struct Announced {
    std::string name;  ///< such as "takt-node robot"
    bool sends_more;   ///< true: it has sent more than announcements to this one alone in the last 1.5 s
  };

  /// Creates the participant. Fails if the domain or an address cannot be used, if the process already has a
  /// participant, or if the calling thread is real-time. With DDS Security it also fails if
  /// security::read_identity() rejects the identity, if the identity is not valid for this domain, or if the
  /// options name a discovery server.
  static Result<std::shared_ptr<Participant>> create(const ParticipantOptions& options);
  virtual ~Participant() = default;

  /// Returns the identity of this process; empty if DDS Security is off.
  [[nodiscard]] virtual const std::optional<security::Identity>& identity() const noexcept = 0;
  /// Returns the number of packets that the filter dropped, so that Fast DDS did not read them.
  [[nodiscard]] virtual std::uint64_t refused() const noexcept = 0;
  /// Returns a text about each peer or discovery server whose name cannot be resolved; empty if there is
  /// none.
  [[nodiscard]] virtual std::string unresolved() const = 0;
  /// Returns the participants that this one has found and not lost.
  [[nodiscard]] virtual std::vector<Announced> announced() const = 0;
  /// Returns a sentence that says why samples do not reach this device now, although it answers. Empty if
  /// nothing indicates that. Known only for devices whose status a Reader<DeviceStatus> has received.
  [[nodiscard]] virtual std::string obstacle(const std::string& device) const = 0;
  /// Returns a sentence that says why the identity of this device, which was accepted before, no longer is.
  /// Empty if that is not so.
  [[nodiscard]] virtual std::string rejection_of(const std::string& device) const = 0;

 protected:
  Participant() = default;
};

}  // namespace takt::dds
