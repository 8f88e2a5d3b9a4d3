// Observes the cells of a domain from a program that is not part of them.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/wire/cell_state.hpp>
#include <takt/dds/participant.hpp>

namespace takt::client {

/// If no node was discovered for this time, usually all nodes have been discovered, even a node that no other
/// node names.
inline constexpr std::chrono::milliseconds kQuiet{600};

/// Holds the latest status of every device and module whose node was discovered. A node's present state
/// arrives as soon as the node is discovered. Any thread may call it.
class Observer {
 public:
  /// The callbacks. Threads of Fast DDS call them one at a time. They must be short and must not call the
  /// observer.
  struct News {
    /// Receives a module's present state when its node is discovered, then each transition in order.
    std::function<void(const LifecycleStatus&)> module{};
    /// Receives a device that was found or lost, came back, or changed its status. A change of only the
    /// sequence number and time does not count.
    std::function<void(const wire::ObservedDevice&)> device{};
  };
  struct Options {
    News news{};
    bool statistics = false;  ///< also observe the statistics of modules and executors and the ports' status
  };
  static Result<std::unique_ptr<Observer>> create(std::shared_ptr<dds::Participant> participant,
                                                  Options options);
  static Result<std::unique_ptr<Observer>> create(std::shared_ptr<dds::Participant> participant) {
    return create(std::move(participant), Options{});
  }
  ~Observer();

  /// All devices, as wire::CellState::devices() returns them.
  [[nodiscard]] std::vector<wire::ObservedDevice> devices() const;
  [[nodiscard]] std::vector<wire::ObservedDevice> devices(const std::string& name) const;

  /// Waits at most `limit` until `condition` returns true for the devices. Returns whether it did. The
  /// condition is evaluated at every change and every few milliseconds. It may call the observer.
  bool wait(const std::function<bool(const std::vector<wire::ObservedDevice>&)>& condition,
            Nanoseconds limit) const;
  /// Waits until no new node was discovered for kQuiet, so that discovery should be complete; at most for
  /// `limit`.
  void settle(Nanoseconds limit) const;

 private:
  struct Readers;
  explicit Observer(Options options);
  void heard(const DeviceStatus& status, wire::WriterId writer);
  void changed(const std::function<void(wire::CellState&)>& change);

  Options options_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  wire::CellState cell_state_;
  // The last member, which is destroyed first, so that no callback uses the other members.
  std::unique_ptr<Readers> readers_;
};

}  // namespace takt::client
