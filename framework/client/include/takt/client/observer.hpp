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

/// When this long has passed without a discovery, usually every node has been discovered, also one that no
/// other node names.
inline constexpr std::chrono::milliseconds kQuiet{600};

/// Holds the latest status of every device and module whose node was discovered. The present state arrives
/// as soon as a node is discovered. Any thread.
class Observer {
 public:
  /// Callbacks, called one at a time on threads of Fast DDS. They must be short and must not call the
  /// observer.
  struct News {
    /// A module's state: the present one when its node is discovered, then each transition in order.
    std::function<void(const LifecycleStatus&)> module{};
    /// A device was lost, came back, or changed its status (other than its number and time).
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

  /// As wire::CellState::devices().
  [[nodiscard]] std::vector<wire::ObservedDevice> devices() const;
  [[nodiscard]] std::vector<wire::ObservedDevice> devices(const std::string& name) const;

  /// Waits at most `limit` until `condition` is true of the devices; returns whether it is. Evaluates it at
  /// every change and every few milliseconds. The condition may call the observer.
  bool wait(const std::function<bool(const std::vector<wire::ObservedDevice>&)>& condition,
            Nanoseconds limit) const;
  /// Waits until discovery should be complete: no new node for kQuiet, or `limit` is over.
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
  std::unique_ptr<Readers> readers_;  // last member: destroyed first, so that no callback uses the others
};

}  // namespace takt::client
