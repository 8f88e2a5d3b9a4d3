// A process's place on DDS: one participant, over UDPv4 alone.
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
  model::Discovery discovery;           ///< multicast unless said otherwise
  std::vector<std::string> interfaces;  ///< IPv4 addresses of the only interfaces to use; empty: all
  std::string security{};               ///< the folder of an identity; empty: without DDS Security
  /// Who was refused and why, a sentence: each once, ten in a minute at most. On threads of Fast DDS: not to
  /// take long. None: nobody wants to know.
  std::function<void(const std::string&)> refused{};
};

/// All of a process's topics hang on one participant; several in a process deadlock in this version of Fast
/// DDS. Its threads inherit policy and processors of the thread that creates it. Deleted with everything that
/// it made when the last owner lets go, which must be before main() returns.
class Participant {
 public:
  /// Fails where the domain or an address cannot be used and says which, in a process that has a participant
  /// already, and on a real-time thread. With security also where the identity is not in order, as
  /// security::read_identity() says, or not for this domain, and with a discovery server.
  static Result<std::shared_ptr<Participant>> create(const ParticipantOptions& options);
  virtual ~Participant() = default;

  /// Uses interfaces that have come up since. Cheap; to be called now and then. Where there was none but the
  /// loopback one before, as on a machine that is starting, every reader and writer is made again, and is
  /// lost for a moment to those on this machine. Later ones serve what is made from then on, and who has been
  /// reached by another address goes on by that.
  virtual void rescan_interfaces() = 0;

  /// Who this process is; none without DDS Security.
  [[nodiscard]] virtual const std::optional<security::Identity>& identity() const noexcept = 0;
  /// Packets that were no RTPS messages; Fast DDS never saw them.
  [[nodiscard]] virtual std::uint64_t refused() const noexcept = 0;

 protected:
  Participant() = default;
};

}  // namespace takt::dds
