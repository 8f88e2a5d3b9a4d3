// A node's publisher to DDS: what an agent says goes to the topics, by threads of its own.
#pragma once

#include <functional>
#include <memory>

#include <takt/core/result.hpp>
#include <takt/dds/participant.hpp>
#include "publisher.hpp"

namespace takt::node {

class DdsPublisher final : public Publisher {
 public:
  static Result<std::unique_ptr<DdsPublisher>> create(std::shared_ptr<dds::Participant> participant);
  /// Takes back what was said and waits a little until everybody has it.
  ~DdsPublisher() override;

  /// Who sends replies. To be told before the first command can come.
  void answer_by(std::function<void(const dds::WholeReply&)> replies);
  /// By the main loop, each time around.
  void sign();

  void reply(const dds::WholeReply& reply) override;
  void say(const LifecycleStatus& status) override;
  void say(const DeviceStatus& status) override;
  void say(const Measures& measures) override;
  void say(const FaultEvent& event) override;
  void take_back(const std::vector<LifecycleStatus>& modules, const Measures& measures) override;

 private:
  struct Inside;
  explicit DdsPublisher(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::node
