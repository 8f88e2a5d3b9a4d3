#include "discovery_listener.hpp"

#include <algorithm>
#include <limits>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>


#include <takt/core/words.hpp>

namespace takt::dds {

namespace {

constexpr std::size_t kMostSeen = 4096;

std::string printed_address_of(const rtps::ParticipantProxyData& data) {
  for (const rtps::Locator_t& locator : data.metatraffic_locators.unicast) {
    if (locator.kind == LOCATOR_KIND_UDPv4) return rtps::IPLocator::toIPv4string(locator);
  }
  return {};
}

wire::ParticipantNumber number_in(const rtps::GuidPrefix_t& prefix) {
  wire::ParticipantNumber number{};
  std::copy(std::begin(prefix.value), std::end(prefix.value), number.begin());
  return number;
}

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

void DiscoveryListener::on_participant_discovery(fast::DomainParticipant*,
                                                 rtps::ParticipantDiscoveryInfo&& info) {
  using Info = rtps::ParticipantDiscoveryInfo;
  const rtps::ParticipantProxyData& data = info.info;
  std::unique_lock lock{mutex_};
  if (info.status == Info::REMOVED_PARTICIPANT || info.status == Info::DROPPED_PARTICIPANT) {
    seen_.erase(data.m_guid.guidPrefix);
    certificates_.erase(data.m_guid.guidPrefix);
    filter_.unauthenticated.left(number_in(data.m_guid.guidPrefix));
    return;
  }
  if (seen_.size() >= kMostSeen) seen_.clear();
  Seen& seen = seen_[data.m_guid.guidPrefix];
  seen.name = data.m_participantName.to_string();
  seen.address = printed_address_of(data);
  for (const auto& property : data.identity_token_.properties()) {
    if (property.name() == "dds.cert.sn") seen.subject = property.value();
    if (property.name() == "dds.ca.sn") seen.authority = property.value();
  }
  // Report a participant whose identity another authority has issued. If such a participant starts the
  // authentication and rejects this process, Fast DDS reports nothing, or reports it only after 14 s.
  const bool foreign = !seen.authority.empty() && seen.authority != mine_.authority;
  lock.unlock();
  if (foreign) report_rejected(data.m_guid.guidPrefix);
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

void DiscoveryListener::onParticipantAuthentication(fast::DomainParticipant*,
                                                    rtps::ParticipantAuthenticationInfo&& info) {
  if (info.status == rtps::ParticipantAuthenticationInfo::UNAUTHORIZED_PARTICIPANT)
    report_rejected(info.guid.guidPrefix);
  else
    filter_.unauthenticated.authenticated(number_in(info.guid.guidPrefix));
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
