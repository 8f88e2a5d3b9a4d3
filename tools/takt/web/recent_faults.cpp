#include "web/recent_faults.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <unordered_set>
#include <utility>

#include <takt/model/json.hpp>

#include "web/samples_json.hpp"

namespace takt::tool::web {

std::string RecentFaults::add(const model::Fault& fault) {
  std::string text = model::json_text(fault_json(fault));
  events_.push_back({fault.time_ns, text});
  forget();
  return text;
}

void RecentFaults::add_record(const std::vector<model::Fault>& events, bool complete) {
  std::deque<Event> all;
  {
    std::unordered_set<std::string_view> known;
    for (const Event& event : events_) known.insert(event.text);
    for (const model::Fault& fault : events) {
      std::string text = model::json_text(fault_json(fault));
      if (!known.contains(text)) all.push_back({fault.time_ns, std::move(text)});
    }
  }
  first_ += events_.size();  // a page that asks for events before a former number gets none
  std::ranges::move(events_, std::back_inserter(all));
  std::ranges::stable_sort(all, {}, &Event::time_ns);
  events_ = std::move(all);
  if (!complete && !events.empty()) complete_since_ns_ = std::max(complete_since_ns_, events.front().time_ns);
  forget();
}

void RecentFaults::forget() {
  const auto is_old = [this] {
    return events_.back().time_ns - events_.front().time_ns > Nanoseconds{kKept}.count();
  };
  while (events_.size() > kMost || (events_.size() > kNewest && is_old())) {
    complete_since_ns_ = std::max(complete_since_ns_, events_.front().time_ns);
    events_.pop_front();
    ++first_;
  }
}

std::string RecentFaults::newest() const {
  return members(events_.size() - std::min(events_.size(), kNewest), events_.size());
}

std::string RecentFaults::before(std::uint64_t number) const {
  const std::size_t end = number > first_ && number - first_ <= events_.size() ? number - first_ : 0;
  return members(end - std::min(end, kMostAtOnce), end);
}

std::string RecentFaults::members(std::size_t begin, std::size_t end) const {
  std::string text = "\"events\":[";
  for (std::size_t i = begin; i < end; ++i) {
    if (i > begin) text += ',';
    text += events_[i].text;
  }
  text += "],\"older\":" + std::to_string(begin == 0 ? 0 : first_ + begin);
  return text + ",\"complete_since_ms\":" + std::to_string(complete_since_ns_ / 1'000'000);
}

}  // namespace takt::tool::web
