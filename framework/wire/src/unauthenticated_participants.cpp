#include <takt/wire/unauthenticated_participants.hpp>

#include <algorithm>

namespace takt::wire {

bool UnauthenticatedParticipants::admit(const Announcement& announcement, std::uint32_t address,
                                        Clock::time_point now) {
  if (announcement.of != Announcement::Of::sender || announcement.lease_s == 0 ||
      announcement.lease_s > kLongestLease)
    return false;
  const auto until = now + std::chrono::seconds{std::max(announcement.lease_s + 1, kShortestStay)};
  const std::lock_guard lock{mutex_};
  if (const auto found = known_.find(announcement.number); found != known_.end()) {
    found->second.until = until;
    return true;
  }
  std::size_t& here = unauthenticated_[address];
  if (here >= kOfOneAddress || unauthenticated_total_ >= kInAll) {
    if (here == 0) unauthenticated_.erase(address);
    return false;
  }
  ++here;
  ++unauthenticated_total_;
  known_[announcement.number] = {.address = address, .authenticated = false, .until = until};
  return true;
}

void UnauthenticatedParticipants::left(const ParticipantNumber& number) {
  const std::lock_guard lock{mutex_};
  if (const auto found = known_.find(number); found != known_.end() && found->second.authenticated)
    known_.erase(found);
}

void UnauthenticatedParticipants::authenticated(const ParticipantNumber& number) {
  const std::lock_guard lock{mutex_};
  if (const auto found = known_.find(number); found != known_.end()) count_authenticated(found->second);
}

void UnauthenticatedParticipants::count_authenticated(Known& one) {
  if (one.authenticated) return;
  one.authenticated = true;
  --unauthenticated_total_;
  if (const auto here = unauthenticated_.find(one.address); --here->second == 0) unauthenticated_.erase(here);
}

std::vector<ParticipantNumber> UnauthenticatedParticipants::remove_expired(Clock::time_point now) {
  std::vector<ParticipantNumber> expired;
  const std::lock_guard lock{mutex_};
  for (auto& [number, known] : known_) {
    if (known.until > now) continue;
    count_authenticated(known);
    expired.push_back(number);
  }
  for (const ParticipantNumber& number : expired) known_.erase(number);
  return expired;
}

}  // namespace takt::wire
