// A bridge: moves samples between the links of a device and another DDS domain.
//
// Each domain needs its own participant, and several participants in one process deadlock in this version of
// Fast DDS. So each other domain has its own bridge process, which is takt-node started with TAKT_GATEWAY_FD.
// The bridge process shares the memory of the links with the node. If the bridge process ends, the node
// restarts it.
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

/// A flow that the bridge moves, and the memory of the flow's links.
struct BridgedFlow {
  dds::Flow flow;
  bool outgoing = true;
  std::vector<const os::SharedMemory*> links;
};

class Bridge {
 public:
  struct Options {
    std::string device;  ///< the device's name, for messages
    int domain = 0;
    std::vector<std::string> peers;  ///< addresses at which the bridge searches for participants; empty for
                                     ///< multicast
    const os::SharedMemory* wake_word = nullptr;
    std::uint32_t place = 1;  ///< the number of the bridge's bit in WakeWord::gateway_sleeps, 1 to 31
    std::vector<BridgedFlow> flows;
  };

  /// Starts the bridge process. The memory that `options` points to must outlive the bridge.
  static Result<std::unique_ptr<Bridge>> start(Options options);
  ~Bridge();

  /// Returns success if the bridge process has opened all flows, and problems if it could not open them.
  /// Empty while this is not known. Does not wait.
  [[nodiscard]] const std::optional<Result<void>>& opened() const noexcept { return opened_; }
  /// Returns the health of the flow with this index in the options. The bridge reported it at most 250 ms
  /// ago.
  [[nodiscard]] const wire::FlowHealth& health(std::size_t flow) const { return health_.at(flow); }
  [[nodiscard]] int domain() const noexcept { return options_.domain; }

  /// Reads the messages of the bridge process, and restarts the process if it has ended. Does not wait.
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
/// The main function of the bridge process. Moves samples until the node that started the process has ended.
/// Returns the exit status. For `interfaces`, see dds::ParticipantOptions.
int run_bridge(const std::vector<std::string>& interfaces);

}  // namespace takt::node
