#include <takt/agent/joint_update.hpp>

#include <algorithm>

namespace takt::agent {

JointUpdate::Decision JointUpdate::step(Instant now, const std::map<std::string, Vote>& others) {
  const auto first = [&others](Vote vote) {
    return std::find_if(others.begin(), others.end(), [vote](const auto& one) { return one.second == vote; });
  };
  if (first(Vote::kept) != others.end()) return Decision::keep;
  if (const auto undone = first(Vote::undone); undone != others.end()) {
    why_ = "device " + undone->first + " has not made its changes";
    return Decision::undo;
  }
  const bool all =
      std::all_of(others.begin(), others.end(), [](const auto& one) { return one.second == Vote::changed; });
  if (all && !added_) return Decision::keep;
  // A lost device may have decided already, so nothing is decided without it.
  const auto absent = first(Vote::absent);
  if (absent == others.end() || first(Vote::nothing) != others.end()) {
    absent_since_.reset();
  } else if (!absent_since_) {
    absent_since_ = now;
  } else if (now - *absent_since_ > kAbsent) {
    why_ = "device " + absent->first + " takes no part in it; its node may have been restarted";
    return Decision::undo;
  }
  return Decision::wait;
}

}  // namespace takt::agent
