#include "participant_removal.hpp"

#include "replaced_function.hpp"

#if TAKT_FASTDDS == 2
#define REMOVE                                                                                   \
  TAKT_RTPS                                                                                      \
      "3PDP25remove_remote_participantERKNS1_6GUID_tENS1_24ParticipantDiscoveryInfo16DISCOVERY_" \
      "STATUSE"
#else
#define REMOVE TAKT_RTPS "3PDP25remove_remote_participantERKNS1_6GUID_tENS1_26ParticipantDiscoveryStatusE"
#endif

namespace takt::dds {

namespace {

using Remove = bool(void* discovery, const rtps::GUID_t& participant, int reason);

Remove* original() noexcept {
  static Remove* const found = replaced<Remove>(REMOVE);
  return found;
}

ReceiveLock* to_pause = nullptr;

}  // namespace

void pause_during_removals(ReceiveLock& lock) noexcept {
  static_cast<void>(original());
  to_pause = &lock;
}

bool remove_participant(void* discovery, const rtps::GUID_t& participant, int reason) asm(REMOVE);

void forget_participant(void* discovery, const rtps::GUID_t& participant) {
  constexpr int kDropped = 3;
  remove_participant(discovery, participant, kDropped);
}

bool remove_participant(void* discovery, const rtps::GUID_t& participant, int reason) {
  const ReceiveLock::Pause pause{*to_pause};
  return original()(discovery, participant, reason);
}

}  // namespace takt::dds
