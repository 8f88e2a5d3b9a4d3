// Sets properties of a component while it runs, between two of its calls.
//
// The setting thread checks the texts and stores the new values separately. The thread that makes the next
// call of the component first takes over all waiting values together, so no value changes during a call. A
// module that is not running takes the values over at its next call, too. The real-time thread reads one
// word; if values are waiting, it swaps them in. The setting thread frees the old values.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <takt/component/property.hpp>

namespace takt::host {

class LiveProperties {
 public:
  using Values = std::vector<std::pair<std::string, std::string>>;

  /// Serves the properties of the component `name` from now on; an empty list ends that. Call serve() before
  /// the other functions, and while no hook is being called.
  void serve(std::vector<PropertyBase*> properties, std::string name);

  /// Sets all these properties or none. Fails with one problem for each property that the component does not
  /// have or whose value it does not accept. The values take effect at the component's next call. Only one
  /// thread at a time may call set(); it may wait for a take_over() in progress.
  Result<void> set(const Values& values);
  /// Returns the value that was set last. Only the setting thread may call it.
  [[nodiscard]] Result<std::string> get(const std::string& name) const;

  /// Takes over the waiting values. Only the thread that is about to call the component may call this, one
  /// thread at a time. A real-time thread may call it.
  void take_over() noexcept {
    if (state_.load(std::memory_order_relaxed) == State::waiting) take_over_waiting();
  }

 private:
  enum class State : std::uint32_t { none, waiting, taken_over };

  [[nodiscard]] Result<PropertyBase*> find(const std::string& name) const;
  void withdraw();
  void take_over_waiting() noexcept;

  std::vector<PropertyBase*> properties_;
  std::string name_;
  std::vector<PropertyBase*> waiting_;  // owned by the setting thread, except while waiting or taken over
  // SYNC: values wait. The setting thread changes none to waiting, and may change waiting back to none. The
  // calling thread changes waiting to taken_over, and then to none.
  std::atomic<State> state_{State::none};
};

}  // namespace takt::host
