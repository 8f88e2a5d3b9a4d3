// Opens a deployment's flows on DDS, and closes them at the end of the deployment. A flow moves samples to or
// from other devices.
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
#include <takt/supervision/platform.hpp>
#include <takt/supervision/wiring.hpp>

namespace takt::node {

class FlowManager final : public supervision::Flows {
 public:
  /// Opens the flows of all connections. The flows on other domains open later; see opened(). `wiring` and
  /// `wake_word` must outlive the flow manager. Fails if DDS rejects a flow; the problem names the flow's
  /// topic.
  static Result<std::unique_ptr<FlowManager>> open(std::shared_ptr<dds::Participant> participant,
                                                   const os::SharedMemory& wake_word,
                                                   const supervision::Wiring& wiring, const model::Cell& cell,
                                                   const std::string& device);

  [[nodiscard]] std::optional<Result<void>> opened() const override;
  /// Closes the flows whose time has expired, and supervises the bridges to other domains.
  void step(Instant now) override;
  [[nodiscard]] std::optional<wire::FlowHealth> health(std::size_t link) const override;
  Result<void> tap(std::uint32_t module, const std::string& port, Instant until) override;
  Result<void> open_service(std::uint32_t module, const std::string& service, Instant until) override;

 private:
  struct Open {
    /// The flow's id in the gateway (on the cell's domain) or its index in the bridge (on other domains).
    dds::Gateway::FlowId id;
    /// The time at which the flow closes; empty for a flow of the whole deployment.
    std::optional<Instant> until{};
    const Bridge* bridge = nullptr;  ///< null for a flow on the cell's domain
  };

  explicit FlowManager(const supervision::Wiring& wiring);
  Result<void> open_flow(std::size_t index, std::optional<Instant> until);
  Result<void> open_until(std::size_t index, Instant until);
  void enable_requests();
  Result<void> open_bridge(int domain, const os::SharedMemory& wake_word, const model::Cell& cell,
                           const std::string& device);
  [[nodiscard]] dds::Flow flow_at(std::size_t index) const;

  const supervision::Wiring& wiring_;
  std::vector<std::optional<Open>> open_;                   // in the order of Wiring::flows()
  std::vector<std::optional<std::size_t>> flows_of_links_;  // index of each link's flow, by link
  std::unique_ptr<dds::Gateway> gateway_;
  std::vector<std::unique_ptr<Bridge>> bridges_;
};

}  // namespace takt::node
