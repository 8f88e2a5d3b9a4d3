// Properties that are set while their component runs, between two of its calls.
//
// The thread that sets checks the texts and leaves the values beside; whoever calls the component next takes
// them over first, all of them together. So a value changes in the middle of no call, whoever makes it, and
// a module that is not running needs no other way: it takes them over when it is called again. The real-time
// side looks at one word; where values wait it swaps them, and those that were there before are freed by the
// thread that sets.
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

  /// Those of a component that is called `name`, before all else; none: no more. While no hook is called.
  void serve(std::vector<PropertyBase*> properties, std::string name);

  /// All of them or none: one problem for each that the component does not have or does not take. They are in
  /// force from its next call on. By one thread at a time; may wait for a take_over() that is going on.
  Result<void> set(const Values& values);
  /// The value that was set last. By the thread that sets.
  [[nodiscard]] Result<std::string> get(const std::string& name) const;

  /// By whoever is about to call the component, one thread at a time. Real-time.
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
  std::vector<PropertyBase*> waiting_;  // of the thread that sets, but while they wait or are taken over
  // SYNC: values wait. From none to waiting by who sets; from there back to none by who sets, or to
  // taken_over by who calls, whichever comes first; from there to none by who calls.
  std::atomic<State> state_{State::none};
};

}  // namespace takt::host
