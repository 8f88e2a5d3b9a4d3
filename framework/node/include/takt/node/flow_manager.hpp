// Opens a deployment's flows on DDS, and closes them at the end of the deployment. A flow moves samples to or
// from other devices.
//
// The creation of a reader or writer on DDS takes up to a millisecond, and may wait until DDS has handled the
// packets that it is receiving. A deployment may have hundreds of flows. So a separate thread opens and
// closes the flows, and no function of this class waits for it, except the destructor.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/model/cell.hpp>
#include <takt/node/bridge.hpp>
#include <takt/node/worker.hpp>
#include <takt/supervision/platform.hpp>
#include <takt/supervision/wiring.hpp>

namespace takt::node {

class FlowManager final : public supervision::Flows {
 public:
  /// Begins to open the flows of all connections; see opened(). `wiring` and `wake_word` must outlive the
  /// flow manager. Fails if a process or thread cannot be started.
  static Result<std::unique_ptr<FlowManager>> open(std::unique_ptr<dds::Gateway> gateway,
                                                   const os::SharedMemory& wake_word,
                                                   const supervision::Wiring& wiring, const model::Cell& cell,
                                                   const std::string& device);

  /// Fails if DDS rejects a flow of a connection; the problem names the flow's topic.
  [[nodiscard]] std::optional<Result<void>> opened() const override;
  /// Closes the flows whose time has expired, and supervises the bridges to other domains.
  void step(Instant now) override;
  [[nodiscard]] std::optional<wire::FlowHealth> health(std::size_t link) const override;
  Result<void> tap(std::uint32_t module, const std::string& port, Instant until, Nanoseconds every) override;
  Result<void> open_service(std::uint32_t module, const std::string& service, Instant until) override;

 private:
  /// A flow that is open, or that the worker opens soon.
  struct Open {
    /// The time at which the flow closes; empty for a flow of the whole deployment.
    std::optional<Instant> until{};
    std::optional<Instant> whole_until{};  ///< until then, an observer wants every sample
    Nanoseconds every{0};                  ///< after that, the newest sample once in this time is enough
    const Bridge* bridge = nullptr;        ///< null for a flow on the cell's domain
    std::size_t in_bridge = 0;             ///< the flow's index in the bridge
  };

  FlowManager(const supervision::Wiring& wiring, const std::string& device,
              std::unique_ptr<dds::Gateway> gateway, std::unique_ptr<Worker> worker);
  void open_until(std::size_t index, Instant until);
  void thin_out(std::size_t index);
  void enable_requests();
  Result<void> open_bridge(int domain, const os::SharedMemory& wake_word, const model::Cell& cell);
  [[nodiscard]] dds::Flow flow_at(std::size_t index) const;
  // These functions run on the worker.
  Result<void> open_now(std::size_t index);
  void open_connected(std::size_t index);
  void open_unconnected(std::size_t index);
  void close_now(std::size_t index);

  const supervision::Wiring& wiring_;
  const std::string device_;
  std::vector<std::optional<Open>> open_;                   // in the order of Wiring::flows()
  std::vector<std::optional<std::size_t>> flows_of_links_;  // index of each link's flow, by link
  std::unique_ptr<dds::Gateway> gateway_;
  std::vector<std::unique_ptr<Bridge>> bridges_;
  // The worker writes the following members.
  std::vector<std::atomic<dds::Gateway::FlowId>> ids_;  // ids in the gateway; 0 while the flow is not open
  std::atomic<std::size_t> unopened_{0};                // number of connected flows that are not open yet
  mutable std::mutex mutex_;
  Problems failure_;                // why a connected flow could not be opened
  std::unique_ptr<Worker> worker_;  // the last member, so that it ends before the other members are destroyed
};

}  // namespace takt::node
