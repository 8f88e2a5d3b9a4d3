// Opens a deployment's flows on DDS, which move its samples to and from other devices, and closes them at its
// end.
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
  /// Opens every flow of a connection. Flows on another domain open later: see opened(). The wiring and the
  /// wake word must outlive it. Fails if DDS rejects a flow, and names its topic.
  static Result<std::unique_ptr<FlowManager>> open(std::shared_ptr<dds::Participant> participant,
                                                   const os::SharedMemory& wake_word, const Wiring& wiring,
                                                   const model::Cell& cell, const std::string& device);

  /// None until all flows are open, or one could not be opened.
  [[nodiscard]] std::optional<Result<void>> opened() const;

  /// Opens the flow of an output without connections for observers, until `until`. Another call extends it.
  Result<void> tap(std::uint32_t module, const std::string& port, Instant until);
  /// Opens the flows by which any program may call a service of the module, until `until`. Another call
  /// extends it.
  Result<void> open_service(std::uint32_t module, const std::string& service, Instant until);
  /// The outgoing flow of a port; null if the module has no such output.
  [[nodiscard]] const PlannedFlow* flow_of(std::uint32_t module, const std::string& port) const;
  /// Closes expired taps and supervises the bridges to other domains. Call it regularly.
  void step(Instant now);

  /// The health of the flow that a wire belongs to; none if the wire has no flow or the flow is not open.
  [[nodiscard]] std::optional<dds::FlowHealth> health(std::size_t wire) const;

 private:
  struct Open {
    dds::Gateway::FlowId id;         ///< in the gateway, or its index in the bridge
    std::optional<Instant> until{};  ///< when a tap ends; none: open for the whole deployment
    const Bridge* bridge = nullptr;  ///< null: the flow is on the cell's domain
  };

  explicit FlowManager(const Wiring& wiring) : wiring_(wiring), open_(wiring.flows().size()) {}
  Result<void> open_flow(std::size_t index, std::optional<Instant> until);
  Result<void> open_until(std::size_t index, Instant until);
  void enable_requests();
  Result<void> open_bridge(int domain, const os::SharedMemory& wake_word, const model::Cell& cell,
                           const std::string& device);
  [[nodiscard]] dds::Flow flow_at(std::size_t index) const;

  const Wiring& wiring_;
  std::vector<std::optional<Open>> open_;  // as Wiring::flows()
  std::unique_ptr<dds::Gateway> gateway_;
  std::vector<std::unique_ptr<Bridge>> bridges_;
};

}  // namespace takt::node
