// Moves samples to and from programs on another DDS domain.
//
// Each domain needs its own participant, and several participants in one process deadlock in this version of
// Fast DDS. So each other domain has its own process, which is takt-node started with TAKT_GATEWAY_FD. This
// process shares the memory of the links, and is restarted when it ends.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/channel/release_slot.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/process.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::node {

/// A flow of the bridge, and the memory of its links.
struct BridgedFlow {
  dds::Flow flow;
  bool outgoing = true;
  std::vector<const os::SharedMemory*> links;
};

class Bridge {
 public:
  struct Options {
    std::string device;  ///< for messages
    int domain = 0;
    std::vector<std::string> peers;  ///< addresses for the discovery of peers; empty for multicast
    const os::SharedMemory* wake_word = nullptr;
    std::uint32_t place = 1;  ///< the bridge's number among the gateways that share the wake word, 1 to 31
    std::vector<BridgedFlow> flows;
  };

  /// Starts the bridge's process. The memory that the options point to must outlive the bridge.
  static Result<std::unique_ptr<Bridge>> start(Options options);
  ~Bridge();

  /// Whether the flows could be opened. Empty until this is known. Does not wait.
  [[nodiscard]] const std::optional<Result<void>>& opened() const noexcept { return opened_; }
  /// The health of the flow with this index in the options, at most a quarter of a second old.
  [[nodiscard]] const wire::FlowHealth& health(std::size_t flow) const { return health_.at(flow); }
  [[nodiscard]] int domain() const noexcept { return options_.domain; }

  /// Reads messages of the bridge's process, and restarts the process if it has ended. Does not wait.
  void step(Instant now);

 private:
  explicit Bridge(Options options);
  Result<void> spawn();
  void handle(const std::string& text);

  Options options_;
  os::Child child_;
  os::MessageSocket socket_;
  Instant started_{};
  std::optional<Result<void>> opened_;
  std::vector<wire::FlowHealth> health_;
};

inline constexpr const char* kGatewayFd = "TAKT_GATEWAY_FD";
/// The main function of the bridge process. Moves samples until its node has ended, and returns the exit
/// status. For `interfaces` see dds::ParticipantOptions.
int run_bridge(const std::vector<std::string>& interfaces);

}  // namespace takt::node
