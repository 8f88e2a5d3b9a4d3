// Where an agent's words go.
#pragma once

#include <string>
#include <vector>

#include <takt/dds/commands.hpp>
#include <takt/node/supervised.hpp>

namespace takt::node {

/// Implemented by DDS (dds_publisher.hpp), and by a test that reads along. Never waits.
class Publisher {
 public:
  virtual ~Publisher() = default;

  virtual void reply(const dds::WholeReply& reply) = 0;
  /// Observers get each of these, in order.
  virtual void say(const LifecycleStatus& status) = 0;
  /// Is what is said of the device from now on, again and again, until the next one.
  virtual void say(const DeviceStatus& status) = 0;
  virtual void say(const Measures& measures) = 0;
  /// Observers get each of these, in order, as far as they keep up; who missed one sees that by its number.
  virtual void say(const FaultEvent& event) = 0;
  /// The deployment is over: nobody is told of its modules, executors and ports any more.
  virtual void take_back(const std::vector<LifecycleStatus>& modules, const Measures& measures) = 0;

 protected:
  Publisher() = default;
  Publisher(const Publisher&) = default;
  Publisher& operator=(const Publisher&) = default;
};

}  // namespace takt::node
