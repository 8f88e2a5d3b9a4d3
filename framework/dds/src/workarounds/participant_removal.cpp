#include "participant_removal.hpp"

#include <fastdds/rtps/builtin/discovery/participant/PDP.h>
#include "replaced_function.hpp"

namespace {

namespace rtps = eprosima::fastrtps::rtps;

using Remove = bool(rtps::PDP*, const rtps::GUID_t&, rtps::ParticipantDiscoveryInfo::DISCOVERY_STATUS);

Remove* original() noexcept {
  static Remove* const found = takt::dds::replaced<Remove>(
      "_ZN8eprosima8fastrtps4rtps3PDP25remove_remote_participantERKNS1_6GUID_tENS1_24ParticipantDiscoveryInfo"
      "16DISCOVERY_STATUSE");
  return found;
}

takt::dds::ReceiveLock* to_pause = nullptr;

}  // namespace

namespace takt::dds {

void pause_during_removals(ReceiveLock& lock) noexcept {
  static_cast<void>(original());
  to_pause = &lock;
}

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

bool PDP::remove_remote_participant(const GUID_t& participant,
                                    ParticipantDiscoveryInfo::DISCOVERY_STATUS reason) {
  const takt::dds::ReceiveLock::Pause pause{*to_pause};
  return original()(this, participant, reason);
}

}  // namespace eprosima::fastrtps::rtps
