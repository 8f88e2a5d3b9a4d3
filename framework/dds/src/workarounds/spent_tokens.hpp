// With DDS Security: frees the keys that a participant sends to the readers and writers of each new
// participant. Fast DDS 2.9.1 keeps them for ever (its issue 4553): some 115 kB for each `takt status`. Not
// for other rooms.
#pragma once

namespace takt::dds {

/// From now on keys are dropped once they have arrived or their receiver has left. Call it before the only
/// participant of this process is created.
void drop_spent_tokens() noexcept;

}  // namespace takt::dds
