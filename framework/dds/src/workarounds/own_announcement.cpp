#include "own_announcement.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <fastdds/rtps/builtin/data/ParticipantProxyData.h>
#include <fastdds/rtps/builtin/data/ReaderProxyData.h>
#include <fastdds/rtps/builtin/data/WriterProxyData.h>
#include <fastdds/rtps/builtin/discovery/participant/PDP.h>
#include <fastdds/rtps/builtin/discovery/participant/PDPSimple.h>
#include <fastdds/rtps/resources/TimedEvent.h>
#include "../fast_dds.hpp"
#include "replaced_function.hpp"

namespace {

namespace rtps = eprosima::fastrtps::rtps;

using Begin = bool(rtps::PDP*, rtps::RTPSParticipantImpl*);
using Assign = void(rtps::PDPSimple*, rtps::ParticipantProxyData*);
using SetLocators = void(void*, const rtps::LocatorList_t&);
using Matches = bool(void*);
using SetInterval = void(rtps::PDP*);

Begin* original() noexcept {
  static Begin* const found =
      takt::dds::replaced<Begin>("_ZN8eprosima8fastrtps4rtps3PDP7initPDPEPNS1_19RTPSParticipantImplE");
  return found;
}

Assign* original_assign() noexcept {
  static Assign* const found = takt::dds::replaced<Assign>(
      "_ZN8eprosima8fastrtps4rtps9PDPSimple21assignRemoteEndpointsEPNS1_20ParticipantProxyDataE");
  return found;
}

// The longest time that another participant is expected to need to handle all packets sent to it.
constexpr std::chrono::milliseconds kSilence{500};

// Fast DDS gives no access to its participant discovery (PDP), so initPDP() keeps it.
std::function<void(takt::dds::PacketFilter&, bool)> leave_and_join;
std::function<void(const rtps::GUID_t&)> forget_one;
std::function<void()> set_own_addresses;
std::function<void(bool changed)> announce;
std::function<void(const rtps::GuidPrefix_t&)> assign_client;
thread_local std::optional<rtps::GuidPrefix_t> changed_client;
std::function<void()> announce_soon;

bool follows_others = false;
bool is_server = false;

std::mutex addresses_mutex;
std::vector<takt::os::Ipv4> own_addresses;  // empty until the first change

template <class Locators>
void replace_addresses(Locators& unicast, std::uint32_t port) {
  unicast.clear();
  for (const takt::os::Ipv4& address : own_addresses) {
    rtps::Locator_t locator;
    locator.kind = LOCATOR_KIND_UDPv4;
    locator.port = port;
    rtps::IPLocator::setIPv4(locator, address[0], address[1], address[2], address[3]);
    unicast.push_back(locator);
  }
}

// The transport has replaced the addresses of participants on this machine.
bool is_here(const rtps::ParticipantProxyData& one) {
  const auto& addresses = one.metatraffic_locators.unicast;
  return std::any_of(addresses.begin(), addresses.end(),
                     [](const rtps::Locator_t& each) { return rtps::IPLocator::isLocal(each); });
}

// Called only for the readers and writers of this participant. Their own lists are never updated.
void set_announced(rtps::RemoteLocatorList& list, const rtps::LocatorList_t& of_creation) {
  const std::lock_guard lock{addresses_mutex};
  if (own_addresses.empty() || of_creation.empty()) {
    list.unicast.clear();
    for (const rtps::Locator_t& each : of_creation) list.add_unicast_locator(each);
  } else {
    replace_addresses(list.unicast, of_creation.begin()->port);
  }
}

}  // namespace

namespace takt::dds {

void prepare_own_announcement(bool follows, bool serves) noexcept {
  follows_others = follows;
  is_server = serves;
  static_cast<void>(original());
  static_cast<void>(original_assign());
  static_cast<void>(replaced<Matches>("_ZN8eprosima8fastrtps4rtps9PDPSimple20updateInfoMatchesEDPEv"));
  static_cast<void>(
      replaced<SetInterval>("_ZN8eprosima8fastrtps4rtps3PDP30set_next_announcement_intervalEv"));
  for (const char* name : {"_ZN8eprosima8fastrtps4rtps15ReaderProxyData30set_announced_unicast_locatorsERKNS_"
                           "7fastdds4rtps11LocatorListE",
                           "_ZN8eprosima8fastrtps4rtps15WriterProxyData30set_announced_unicast_locatorsERKNS_"
                           "7fastdds4rtps11LocatorListE"})
    static_cast<void>(replaced<SetLocators>(name));
}

void announce_addresses(fast::DomainParticipant&, const std::vector<os::Ipv4>& addresses) {
  {
    const std::lock_guard lock{addresses_mutex};
    own_addresses = addresses;
  }
  set_own_addresses();
  announce(true);
}

void announce_again() { announce(false); }
void has_announced(const rtps::GuidPrefix_t& participant) noexcept { changed_client = participant; }
void follow_client() {
  if (is_server && changed_client) assign_client(*std::exchange(changed_client, {}));
}
void forget(const wire::ParticipantNumber& participant) {
  rtps::GUID_t other{{}, rtps::c_EntityId_RTPSParticipant};
  std::copy(participant.begin(), participant.end(), other.guidPrefix.value);
  forget_one(other);
}
void forget_silent(const wire::ParticipantNumber&) {}
void rejoin(PacketFilter& filter, const std::map<wire::ParticipantNumber, std::string>&, bool also_here) {
  leave_and_join(filter, also_here);
}

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

void ReaderProxyData::set_announced_unicast_locators(const LocatorList_t& of_creation) {
  set_announced(remote_locators_, of_creation);
}

void WriterProxyData::set_announced_unicast_locators(const LocatorList_t& of_creation) {
  set_announced(remote_locators_, of_creation);
}

// Fast DDS asks this when a known participant announces something new.
bool PDPSimple::updateInfoMatchesEDP() { return follows_others; }

// Fast DDS sends the first announcements in a fixed period. If it is short, they fill a slow link; if it is
// long, a lost one delays discovery.
void PDP::set_next_announcement_interval() {
  const std::lock_guard lock{*mp_mutex};
  Duration_t& pause = initial_announcements_.period;
  resend_participant_info_event_->update_interval(
      initial_announcements_.count > 0 ? pause
                                       : m_discovery.discovery_config.leaseDuration_announcementperiod);
  if (initial_announcements_.count == 0) return;
  --initial_announcements_.count;
  pause = Duration_t{2 * pause.to_ns() / 1e9L};
}

// Called when this participant has found another one. Fast DDS then announces this participant once, perhaps
// before the other one can receive it.
void PDPSimple::assignRemoteEndpoints(ParticipantProxyData* other) {
  original_assign()(this, other);
  announce_soon();
}

bool PDP::initPDP(RTPSParticipantImpl* participant) {
  forget_one = [this](const GUID_t& other) {
    remove_remote_participant(other, ParticipantDiscoveryInfo::DROPPED_PARTICIPANT);
  };
  announce = [this](bool changed) { announceParticipantState(changed, false); };
  announce_soon = [this] {
    const std::lock_guard lock{*mp_mutex};
    if (initial_announcements_.count > 0) return;
    initial_announcements_.count = takt::dds::kMoreAnnouncements;
    initial_announcements_.period = takt::dds::duration(takt::dds::kMorePause);
    stopParticipantAnnouncement();
    set_next_announcement_interval();
    resetParticipantAnnouncement();
  };
  set_own_addresses = [this] {
    const std::lock_guard lock{*mp_mutex};
    const std::lock_guard addresses{addresses_mutex};
    ParticipantProxyData& own = *getLocalParticipantProxyData();
    for (RemoteLocatorList* list : {&own.metatraffic_locators, &own.default_locators}) {
      if (!list->unicast.empty()) replace_addresses(list->unicast, list->unicast.begin()->port);
    }
  };
  assign_client = [this](const GuidPrefix_t& number) {
    ParticipantProxyData* const client = get_participant_proxy_data(number);
    if (client != nullptr) assignRemoteEndpoints(client);
  };
  leave_and_join = [this](takt::dds::PacketFilter& filter, bool also_here) {
    using takt::dds::Silence;
    filter.silence = also_here ? Silence::none : Silence::on_this_machine;
    announceParticipantState(true, true);
    // A message of an earlier authentication, or a second copy of the announcement that this participant
    // leaves, must not meet the new authentication. It would hang for ever.
    filter.silence = Silence::everywhere;
    announceParticipantState(true, false);
    filter.silence = also_here ? Silence::everywhere : Silence::on_other_machines;
    std::this_thread::sleep_for(kSilence);
    std::vector<GUID_t> others;
    {
      const std::lock_guard lock{*mp_mutex};
      for (const ParticipantProxyData* each : participant_proxies_) {
        if (also_here || !is_here(*each)) others.push_back(each->m_guid);
      }
    }
    // remove_remote_participant() ignores this participant itself.
    for (const GUID_t& each : others) forget_one(each);
    filter.silence = Silence::none;
    announceParticipantState(true, false);
  };
  return original()(this, participant);
}

}  // namespace eprosima::fastrtps::rtps
