#include <takt/component/live_properties.hpp>

#include <algorithm>
#include <string_view>
#include <thread>

#include <takt/core/log_level.hpp>
#include <takt/core/words.hpp>

namespace takt {

void LiveProperties::serve(std::vector<PropertyBase*> properties, std::string owner) {
  properties_ = std::move(properties);
  owner_ = std::move(owner);
  waiting_.clear();
  state_.store(State::none, std::memory_order_relaxed);
}

Result<PropertyBase*> LiveProperties::find(const std::string& name) const {
  std::vector<std::string_view> names;
  for (PropertyBase* property : properties_) {
    if (property->name() == name) return property;
    names.emplace_back(property->name());
  }
  names.emplace_back(kLogLevelProperty);
  return fail(owner_ + " has no property " + in_quotes(name), suggestion(name, names));
}

Result<std::string> LiveProperties::get(const std::string& name) const {
  const auto property = find(name);
  if (!property) return property.problems();
  return (*property)->value_text();
}

Result<void> LiveProperties::set(const Values& values) {
  Problems problems;
  const auto add = [&problems](const Problems& more) {
    problems.insert(problems.end(), more.begin(), more.end());
  };
  std::vector<PropertyBase*> properties;
  for (const auto& [name, text] : values) {
    const auto property = find(name);
    if (!property) {
      add(property.problems());
    } else if (const auto checked = (*property)->check(text); !checked) {
      add(checked.problems());
    } else {
      properties.push_back(*property);
    }
  }
  if (!problems.empty()) return problems;

  withdraw();
  for (std::size_t i = 0; i < values.size(); ++i) {
    // This cannot fail, because check() has accepted the text above.
    static_cast<void>(properties[i]->propose(values[i].second));
    if (std::find(waiting_.begin(), waiting_.end(), properties[i]) == waiting_.end())
      waiting_.push_back(properties[i]);
  }
  state_.store(State::waiting, std::memory_order_release);  // after the proposals
  return {};
}

// Makes the setting thread the owner of waiting_. Properties whose new value the calling thread has not taken
// over yet stay in waiting_.
void LiveProperties::withdraw() {
  // If the calling thread has taken values over, this load acquires its changes to the properties; it pairs
  // with the last store in take_over_waiting().
  State state = State::waiting;
  if (state_.compare_exchange_strong(state, State::none, std::memory_order_acquire)) return;
  // The calling thread is taking the values over. It only swaps a few values, so this loop is short unless
  // the calling thread is preempted.
  while (state_.load(std::memory_order_acquire) != State::none)
    std::this_thread::sleep_for(std::chrono::microseconds{50});
  waiting_.clear();
}

void LiveProperties::take_over_waiting() noexcept {
  State state = State::waiting;  // acquires the proposals; pairs with the last store in set()
  if (!state_.compare_exchange_strong(state, State::taken_over, std::memory_order_acquire)) return;
  for (PropertyBase* property : waiting_) property->take_over();
  state_.store(State::none, std::memory_order_release);  // after the values are taken over
}

}  // namespace takt
