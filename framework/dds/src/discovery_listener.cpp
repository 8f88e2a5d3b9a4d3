#include "discovery_listener.hpp"

#include <algorithm>
#include <limits>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include <takt/core/words.hpp>
#include <takt/os/clock.hpp>
#include "workarounds/own_announcement.hpp"

namespace takt::dds {

namespace {

constexpr std::size_t kMostSeen = 4096;

}  // namespace

std::optional<security::Subject> announced_subject(std::string_view text) {
  const auto part = [&text](std::string_view begin) -> std::string_view {
    const std::size_t at = text.find(begin);
    if (at == std::string_view::npos) return {};
    const std::string_view rest = text.substr(at + begin.size());
    return rest.substr(0, rest.find('/'));
  };
  return security::subject_from("CN=" + std::string{part("/CN=")} + ",OU=" + std::string{part("/OU=")} +
                                ",O=" + std::string{part("/O=")});
}

std::map<wire::ParticipantNumber, std::string> KnownParticipants::names() const {
  const std::lock_guard lock{names_mutex_};
  return names_;
}

void KnownParticipants::found(const rtps::GuidPrefix_t& participant, const std::string& name) {
  has_announced(participant);
  const std::lock_guard lock{names_mutex_};
  names_[number_in(participant)] = name;
}

void KnownParticipants::lost(const rtps::GuidPrefix_t& participant) {
  const std::lock_guard lock{names_mutex_};
  names_.erase(number_in(participant));
}

bool DiscoveryListener::is_device(const rtps::GUID_t& writer, const std::string& device) {
  const std::lock_guard lock{mutex_};
  auto found = prefixes_.find(device);
  if (found == prefixes_.end()) {
    if (prefixes_.size() >= kMostSeen) prefixes_.clear();
    const security::Subject subject{mine_.subject.cell, security::Role::device, device};
    found = prefixes_.emplace(device, security::prefix_of(subject)).first;
  }
  return std::equal(found->second.begin(), found->second.end(), std::begin(writer.guidPrefix.value));
}

void DiscoveryListener::impostor(const rtps::GUID_t& writer, const std::string& topic,
                                 const std::string& path) {
  tell("rejected: " + who(writer.guidPrefix) + " publishes on " + topic + " for " + brief(path) +
       ", but may publish only for itself");
}

std::string DiscoveryListener::who(const rtps::GuidPrefix_t& prefix) {
  const std::lock_guard lock{mutex_};
  const auto found = seen_.find(prefix);
  const auto certificate = certificates_.find(prefix);
  if (found == seen_.end() && certificate == certificates_.end()) return "an unknown participant";
  const Seen seen = found == seen_.end() ? Seen{} : found->second;
  const std::string where = seen.address.empty() ? "" : " at " + seen.address;
  // The subject of a certificate is authenticated, unlike that of an announcement.
  if (const auto subject = certificate != certificates_.end()
                               ? std::optional{certificate->second.says.subject}
                               : announced_subject(seen.subject)) {
    return std::string{to_text(subject->role)} + " " + subject->name +
           (subject->cell == mine_.subject.cell ? "" : " of cell " + subject->cell) + where;
  }
  return "participant " + in_quotes(seen.name) + where;
}

void DiscoveryListener::certified(const rtps::GuidPrefix_t& participant, const x509_st& certificate) {
  losses.authenticated(number_in(participant), os::now());
  {
    const std::lock_guard lock{mutex_};
    Certificate& of = certificates_[participant];
    of = {.says = security::certified(certificate)};
    if (of.says.subject.role == security::Role::device) rejections_.erase(of.says.subject.name);
  }
  // Fast DDS has just checked the time, but with the list of revoked certificates that this process began
  // with.
  reject_invalid(std::numeric_limits<std::int64_t>::min());
}

void DiscoveryListener::check_certificates(std::int64_t now) {
  Result<void> updated;
  bool revoked = false;
  {
    const std::lock_guard lock{mutex_};
    updated = revocations_.update();
    revoked = revocations_.contains(mine_.serial) && !std::exchange(mine_is_revoked_, true);
  }
  if (!updated) notices_.tell_unlimited("warning: " + in_words(updated.problems()));
  if (revoked)
    notices_.tell_unlimited("warning: the identity of this process was revoked; the others reject it");
  reject_invalid(now);
}

std::string DiscoveryListener::invalidity(const security::Certified& certificate, std::int64_t now) const {
  const std::string renew = "run takt secure renew DIR " + certificate.subject.name;
  if (revocations_.contains(certificate.serial)) return "it was revoked; to accept it again, " + renew;
  if (now < certificate.until) return {};
  return security::expired_text(certificate.until) + "; " + renew + ", copy its folder again and restart it";
}

void DiscoveryListener::reject_invalid(std::int64_t now) {
  std::vector<std::string> texts;
  {
    const std::lock_guard lock{mutex_};
    for (auto& [prefix, each] : certificates_) {
      std::string why = each.rejected ? std::string{} : invalidity(each.says, now);
      if (why.empty()) continue;
      why.insert(0, "its identity is no longer accepted: ");
      each.rejected = true;
      filter_.reject(number_in(prefix));
      const security::Subject& subject = each.says.subject;
      if (subject.role == security::Role::device) rejections_[subject.name] = why;
      const auto seen = seen_.find(prefix);
      const std::string where =
          seen == seen_.end() || seen->second.address.empty() ? "" : " at " + seen->second.address;
      texts.push_back("rejected: " + std::string{to_text(subject.role)} + " " + subject.name + where + ": " +
                      why);
    }
  }
  for (const std::string& text : texts) notices_.tell_unlimited(text);
}

std::string DiscoveryListener::rejection_of(const std::string& device) {
  const std::lock_guard lock{mutex_};
  const auto found = rejections_.find(device);
  return found == rejections_.end() ? std::string{} : found->second;
}

void DiscoveryListener::announced(const wire::Announcement& announcement, const os::Ipv4& from) {
  if (announcement.port != 0) losses.announced(announcement.number, {from, announcement.port}, os::now());
  rtps::GuidPrefix_t prefix;
  std::copy(announcement.number.begin(), announcement.number.end(), std::begin(prefix.value));
  {
    const std::lock_guard lock{mutex_};
    // Anybody can announce something in the name of a participant that has authenticated.
    if (certificates_.contains(prefix)) return;
    if (const auto found = seen_.find(prefix); found != seen_.end()) {
      const Seen& seen = found->second;
      if (seen.name == announcement.name && seen.subject == announcement.subject &&
          seen.authority == announcement.authority)
        return;
    }
    if (seen_.size() >= kMostSeen) seen_.clear();
    seen_[prefix] = {.name = std::string{announcement.name},
                     .address = os::in_dots(from),
                     .subject = std::string{announcement.subject},
                     .authority = std::string{announcement.authority}};
  }
  // Report a participant whose identity another authority has issued. If such a participant starts the
  // authentication and rejects this process, Fast DDS reports nothing.
  if (!announcement.authority.empty() && announcement.authority != mine_.authority) report_rejected(prefix);
}

void DiscoveryListener::lost(const rtps::GuidPrefix_t& participant) {
  KnownParticipants::lost(participant);
  losses.lost(number_in(participant));
  const std::lock_guard lock{mutex_};
  seen_.erase(participant);
  certificates_.erase(participant);
  filter_.unauthenticated.left(number_in(participant));
}

void DiscoveryListener::report_rejected(const rtps::GuidPrefix_t& prefix) {
  Seen seen;
  {
    const std::lock_guard lock{mutex_};
    if (const auto found = seen_.find(prefix); found != seen_.end()) seen = found->second;
  }
  tell("rejected: " + who(prefix) +
       (seen.subject.empty() ? " has no identity of this cell"
        : seen.authority != mine_.authority
            ? ": its identity was issued by another authority"
            : ": its identity was revoked, has expired, or belongs to another participant"));
}

void DiscoveryListener::authenticated(const rtps::GuidPrefix_t& participant, bool accepted) {
  if (accepted)
    filter_.unauthenticated.authenticated(number_in(participant));
  else
    report_rejected(participant);
}

bool DiscoveryListener::look(const std::string& message) {
  // A message has this form: "Error checking create remote writer b5.32.[...]|0.0.1.3 (TOPIC topic not found
  // in allow rule. [...]"
  for (const auto& [begin, does] :
       {std::pair{std::string_view{"Error checking create remote writer "}, "writes"},
        {"Error checking create remote reader ", "reads"}}) {
    if (!message.starts_with(begin)) continue;
    const std::string_view rest = std::string_view{message}.substr(begin.size());
    const std::string_view guid = rest.substr(0, rest.find('|'));
    const std::size_t open = rest.find('(');
    if (open == std::string_view::npos) return false;
    const std::string_view reason = rest.substr(open + 1);
    const std::string topic{reason.substr(0, reason.find(' '))};
    std::optional<rtps::GuidPrefix_t> prefix;
    {
      const std::lock_guard lock{mutex_};
      for (const auto& each : seen_) {
        std::ostringstream text;
        text << each.first;
        if (text.str() == guid) prefix = each.first;
      }
    }
    tell("rejected: " + (prefix ? who(*prefix) : std::string{"an unknown participant"}) + " " + does + " " +
         brief(topic) + " without permission");
    return true;
  }
  return false;
}

}  // namespace takt::dds
