// The interface through which an agent publishes its status, events and replies.
#pragma once

#include <string>
#include <vector>

#include <takt/supervision/supervised.hpp>
#include <takt/wire/assembly.hpp>

namespace takt::agent {

/// The node implements this interface with DDS (dds_publisher.hpp); tests have their own implementations. No
/// function waits.
class Publisher {
 public:
  virtual ~Publisher() = default;

  virtual void reply(const wire::WholeReply& reply) = 0;
  /// Publishes a transition of a module. Observers receive every transition, in order.
  virtual void publish(const LifecycleStatus& status) = 0;
  /// Publishes the status of the device. The publisher repeats the status regularly until a new status
  /// replaces it.
  virtual void publish(const DeviceStatus& status) = 0;
  virtual void publish(const supervision::Measures& measures) = 0;
  /// Publishes an event of the fault record. Observers receive the events in order. A slow observer may miss
  /// events, and detects this by gaps in the sequence numbers.
  virtual void publish(const FaultEvent& event) = 0;
  /// Withdraws the published states and statistics of the modules, executors and ports of a deployment that
  /// has ended.
  virtual void withdraw(const std::vector<LifecycleStatus>& modules,
                        const supervision::Measures& measures) = 0;

 protected:
  Publisher() = default;
  Publisher(const Publisher&) = default;
  Publisher& operator=(const Publisher&) = default;
};

}  // namespace takt::agent
