// Frees the keys that a participant with DDS Security sends to the readers and writers of each new
// participant. Fast DDS 2.9.1 keeps these keys for ever (Fast DDS issue 4553), some 115 kB for each `takt
// status`. Not for other rooms.
#pragma once

namespace takt::dds {

/// From now on, keys are freed once they have arrived or their receiver has left. Call this before the
/// participant of this process is created.
void drop_spent_tokens() noexcept;

}  // namespace takt::dds
