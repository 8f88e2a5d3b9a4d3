// The way of a deployment's samples to and from other devices: the flows of its wiring, open on DDS while it
// lasts.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/dds/participant.hpp>
#include <takt/model/cell.hpp>
#include <takt/node/bridge.hpp>
#include <takt/node/wiring.hpp>

namespace takt::node {

class FlowManager {
 public:
  /// Opens every flow that a connection names; those on a domain of their own open later. The wiring and the
  /// wake_word outlive it. Fails where DDS refuses one, with its topic.
  static Result<std::unique_ptr<FlowManager>> open(std::shared_ptr<dds::Participant> participant,
                                                   const os::SharedMemory& wake_word, const Wiring& wiring,
                                                   const model::Cell& cell, const std::string& device);

  /// None until the last flow is open, or one could not be opened.
  [[nodiscard]] std::optional<Result<void>> opened() const;

  /// Opens the flow of an output that nobody is connected to, for who listens in, until then. Longer when
  /// asked again.
  Result<void> tap(std::uint32_t module, const std::string& port, Instant until);
  /// Opens the flows by which anybody may ask a service of the module, until then. Longer when asked again.
  Result<void> open_service(std::uint32_t module, const std::string& service, Instant until);
  /// The outgoing flow of a port; null where the module has no such output.
  [[nodiscard]] const PlannedFlow* flow_of(std::uint32_t module, const std::string& port) const;
  /// Closes taps that have run out, and looks after gateways to other domains. Now and then.
  void step(Instant now);

  /// Of the flow that a wire belongs to; none where it has none, or it is not open.
  [[nodiscard]] std::optional<dds::FlowHealth> health(std::size_t wire) const;

 private:
  struct Open {
    dds::Gateway::FlowId id;         ///< or its index in the far gateway
    std::optional<Instant> until{};  ///< of a tap
    const Bridge* far = nullptr;
  };

  explicit FlowManager(const Wiring& wiring) : wiring_(wiring), open_(wiring.flows().size()) {}
  Result<void> open_flow(std::size_t index, std::optional<Instant> until);
  Result<void> open_until(std::size_t index, Instant until);
  void let_requests_through();
  Result<void> open_far(int domain, const os::SharedMemory& wake_word, const model::Cell& cell,
                        const std::string& device);
  [[nodiscard]] dds::Flow flow_at(std::size_t index) const;

  const Wiring& wiring_;
  std::vector<std::optional<Open>> open_;  // as Wiring::flows()
  std::unique_ptr<dds::Gateway> gateway_;
  std::vector<std::unique_ptr<Bridge>> far_;
};

}  // namespace takt::node
