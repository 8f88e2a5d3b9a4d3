#include "rejoining.hpp"

#include <chrono>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include <fastdds/rtps/builtin/data/ParticipantProxyData.h>
#include <fastdds/rtps/builtin/discovery/participant/PDP.h>
#include "replaced_function.hpp"

namespace {

namespace rtps = eprosima::fastrtps::rtps;

using Begin = bool(rtps::PDP*, rtps::RTPSParticipantImpl*);

Begin* original() noexcept {
  static Begin* const found =
      takt::dds::replaced<Begin>("_ZN8eprosima8fastrtps4rtps3PDP7initPDPEPNS1_19RTPSParticipantImplE");
  return found;
}

// The longest time that another participant is expected to need to handle all packets sent to it.
constexpr std::chrono::milliseconds kSilence{500};

std::function<void(takt::dds::PacketFilter&)> leave_and_join;

}  // namespace

namespace takt::dds {

void prepare_to_rejoin() noexcept { static_cast<void>(original()); }
void rejoin(PacketFilter& filter) { leave_and_join(filter); }

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

// Fast DDS gives no access to its participant discovery (PDP), so this function keeps it for rejoin().
bool PDP::initPDP(RTPSParticipantImpl* participant) {
  leave_and_join = [this](takt::dds::PacketFilter& filter) {
    announceParticipantState(true, true);
    // A message of an earlier authentication, or a second copy of the announcement that this participant leaves,
    // must not meet the new authentication. It would hang for ever.
    filter.silent = true;
    std::this_thread::sleep_for(kSilence);
    std::vector<GUID_t> others;
    {
      const std::lock_guard lock{*mp_mutex};
      for (const ParticipantProxyData* each : participant_proxies_) others.push_back(each->m_guid);
    }
    // remove_remote_participant() ignores this participant itself.
    for (const GUID_t& each : others)
      remove_remote_participant(each, ParticipantDiscoveryInfo::DROPPED_PARTICIPANT);
    filter.silent = false;
    announceParticipantState(true, false);
  };
  return original()(this, participant);
}

}  // namespace eprosima::fastrtps::rtps
