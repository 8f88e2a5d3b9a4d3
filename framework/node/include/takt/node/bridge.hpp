// Samples to and from programs on another domain of DDS.
//
// A domain needs a participant of its own, and several of those in one process deadlock in this version of
// Fast DDS. So each other domain has a program (takt-node, started with TAKT_GATEWAY_FD), which shares the
// memory of the links; it is started again when it ends.
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

/// What moves, and the memory of its links.
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
    std::vector<std::string> peers;  ///< in place of multicast; none: multicast
    const os::SharedMemory* wake_word = nullptr;
    std::uint32_t place = 1;  ///< among the gateways that share the wake_word: 1 to 31
    std::vector<BridgedFlow> flows;
  };

  /// Starts the program. What the options point to outlives this.
  static Result<std::unique_ptr<Bridge>> start(Options options);
  ~Bridge();

  /// None until the flows are open, or could not be opened; does not wait.
  [[nodiscard]] const std::optional<Result<void>>& opened() const noexcept { return opened_; }
  /// Of a flow, by its index in the options, a quarter of a second ago at most.
  [[nodiscard]] const dds::FlowHealth& health(std::size_t flow) const { return health_.at(flow); }
  [[nodiscard]] int domain() const noexcept { return options_.domain; }

  /// Reads what the program says, and starts it again when it has ended. Does not wait.
  void step(Instant now);

 private:
  explicit Bridge(Options options);
  Result<void> spawn();
  void hear(const std::string& text);

  Options options_;
  os::Child child_;
  os::MessageSocket socket_;
  Instant started_{};
  std::optional<Result<void>> opened_;
  std::vector<dds::FlowHealth> health_;
};

inline constexpr const char* kGatewayFd = "TAKT_GATEWAY_FD";
/// That program: moves samples until its node is gone, and returns the exit status. `interfaces` as
/// dds::ParticipantOptions.
int run_bridge(const std::vector<std::string>& interfaces);

}  // namespace takt::node
