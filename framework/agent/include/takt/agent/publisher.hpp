// The interface by which an agent publishes its status, events and replies.
#pragma once

#include <string>
#include <vector>

#include <takt/supervision/supervised.hpp>
#include <takt/wire/assembly.hpp>

namespace takt::agent {

/// Implemented with DDS (dds_publisher.hpp), and by tests. Never waits.
class Publisher {
 public:
  virtual ~Publisher() = default;

  virtual void reply(const wire::WholeReply& reply) = 0;
  /// Observers receive every transition, in order.
  virtual void publish(const LifecycleStatus& status) = 0;
  /// The status is repeated regularly until the next one replaces it.
  virtual void publish(const DeviceStatus& status) = 0;
  virtual void publish(const supervision::Measures& measures) = 0;
  /// Observers receive the events in order. A slow observer may miss some, and sees that by their numbers.
  virtual void publish(const FaultEvent& event) = 0;
  /// Withdraws the modules, executors and ports of a deployment that has ended.
  virtual void withdraw(const std::vector<LifecycleStatus>& modules,
                        const supervision::Measures& measures) = 0;

 protected:
  Publisher() = default;
  Publisher(const Publisher&) = default;
  Publisher& operator=(const Publisher&) = default;
};

}  // namespace takt::agent
