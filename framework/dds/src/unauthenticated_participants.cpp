#include <takt/dds/unauthenticated_participants.hpp>

#include <algorithm>

namespace takt::dds {

namespace {

constexpr std::chrono::seconds kLookEvery{1};

}  // namespace

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
  take_leave(now);
  std::size_t& here = unproved_[address];
  if (here >= kOfOneAddress || unproved_in_all_ >= kInAll) {
    if (here == 0) unproved_.erase(address);
    return false;
  }
  ++here;
  ++unproved_in_all_;
  known_[announcement.number] = {.address = address, .proved = false, .until = until};
  return true;
}

void UnauthenticatedParticipants::left(const ParticipantNumber& number) {
  const std::lock_guard lock{mutex_};
  if (const auto found = known_.find(number); found != known_.end() && found->second.proved)
    known_.erase(found);
}

void UnauthenticatedParticipants::proved(const ParticipantNumber& number) {
  const std::lock_guard lock{mutex_};
  if (const auto found = known_.find(number); found != known_.end()) count_out(found->second);
}

void UnauthenticatedParticipants::count_out(Known& one) {
  if (one.proved) return;
  one.proved = true;
  --unproved_in_all_;
  if (const auto here = unproved_.find(one.address); --here->second == 0) unproved_.erase(here);
}

void UnauthenticatedParticipants::take_leave(Clock::time_point now) {
  if (now < looked_ + kLookEvery) return;
  looked_ = now;
  for (auto each = known_.begin(); each != known_.end();) {
    if (each->second.until > now) {
      ++each;
      continue;
    }
    count_out(each->second);
    each = known_.erase(each);
  }
}

}  // namespace takt::dds
