// Publishes an agent's output on DDS, on its own threads.
#pragma once

#include <functional>
#include <memory>

#include <takt/agent/publisher.hpp>
#include <takt/core/result.hpp>
#include <takt/dds/participant.hpp>

namespace takt::node {

class DdsPublisher final : public agent::Publisher {
 public:
  static Result<std::unique_ptr<DdsPublisher>> create(std::shared_ptr<dds::Participant> participant);
  /// Withdraws the device's status, and waits at most 200 ms for observers to receive the withdrawal.
  ~DdsPublisher() override;

  /// Sets the function that sends replies. Call set_reply_sender() before the first command can arrive.
  void set_reply_sender(std::function<void(const wire::WholeReply&)> replies);
  /// The main loop calls kick() in each iteration to show that it does not hang; see Heartbeat::kick().
  void kick();
  /// Answers a status that has just arrived from another node; see Heartbeat::heard().
  void heard(const DeviceStatus& status, Instant arrived);

  void reply(const wire::WholeReply& reply) override;
  void publish(const LifecycleStatus& status) override;
  void publish(const DeviceStatus& status) override;
  void publish(const supervision::Measures& measures) override;
  void publish(const FaultEvent& event) override;
  void withdraw(const std::vector<LifecycleStatus>& modules, const supervision::Measures& measures) override;

 private:
  struct Inside;
  explicit DdsPublisher(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::node
