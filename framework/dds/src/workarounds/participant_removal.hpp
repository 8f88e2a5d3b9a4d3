// Lets no packet be handled while a participant is being removed. Only the source files of this room include
// this header.
//
// Otherwise another thread may handle an announcement of the same participant during the removal. Fast DDS
// 2.9.1 then adds the participant again and afterwards removes the readers, the writers and, with DDS
// Security, the authentication that belong to it. It never adds them again, because the participant is known.
#pragma once

#include "../fast_dds.hpp"
#include "receive_lock.hpp"

namespace takt::dds {

/// Makes each removal of a participant pause `lock`. Ends the process if the function of Fast DDS that
/// participant_removal.cpp replaces is missing. Call this function before the participant of this process is
/// created; `lock` must exist as long as this participant.
void pause_during_removals(ReceiveLock& lock) noexcept;
/// Makes the participant discovery of Fast DDS (PDP) forget a participant.
void forget_participant(void* discovery, const rtps::GUID_t& participant);

}  // namespace takt::dds
