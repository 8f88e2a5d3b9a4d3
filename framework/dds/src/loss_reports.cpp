#include "loss_reports.hpp"

namespace takt::dds {

namespace {

// Members that have ended never announce themselves again. If there are so many, all are forgotten.
constexpr std::size_t kMostLost = 4096;
/// Participants announce themselves more often than this.
constexpr Nanoseconds kAnnouncedWithin = std::chrono::seconds{3};

}  // namespace

void LossReports::authenticated(const wire::ParticipantNumber& member, Instant now) {
  const std::lock_guard lock{mutex_};
  members_[member] = {.since = now};
  lost_.erase(member);
}

void LossReports::lost(const wire::ParticipantNumber& member) {
  const std::lock_guard lock{mutex_};
  if (members_.erase(member) == 0) return;
  if (lost_.size() >= kMostLost) lost_.clear();
  lost_[member] = {};
}

void LossReports::announced(const wire::ParticipantNumber& participant, const os::UdpEnd& at, Instant now) {
  const std::lock_guard lock{mutex_};
  const auto found = lost_.find(participant);
  if (found == lost_.end()) return;
  Lost& one = found->second;
  one.at = at;
  if (!one.first_announcement || now - one.last_announcement > kAnnouncedWithin) one.first_announcement = now;
  one.last_announcement = now;
}

std::vector<std::pair<wire::ParticipantNumber, os::UdpEnd>> LossReports::due(Instant now) {
  const std::lock_guard lock{mutex_};
  std::vector<std::pair<wire::ParticipantNumber, os::UdpEnd>> all;
  for (auto& [participant, one] : lost_) {
    if (!one.first_announcement || now - *one.first_announcement < kPatience ||
        now - one.last_announcement > kAnnouncedWithin || now - one.last_report < kReportEvery)
      continue;
    one.last_report = now;
    all.emplace_back(participant, one.at);
  }
  return all;
}

void LossReports::reported(const wire::ParticipantNumber& by, std::optional<Instant> heard, Instant now) {
  const std::lock_guard lock{mutex_};
  const auto found = members_.find(by);
  if (found == members_.end() || now - found->second.since < kNew) return;
  Member& member = found->second;
  if (!member.first_report || now - member.last_report > 2 * kReportEvery ||
      (heard && *heard > *member.first_report))
    member.first_report = now;
  member.last_report = now;
  if (now - *member.first_report < kRepeated) return;
  member.first_report.reset();
  mutual_.push_back(by);
}

std::vector<wire::ParticipantNumber> LossReports::take_mutual() {
  const std::lock_guard lock{mutex_};
  return std::exchange(mutual_, {});
}

}  // namespace takt::dds
