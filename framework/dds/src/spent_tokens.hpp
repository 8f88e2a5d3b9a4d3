// The keys that a participant gives to each newcomer's readers and writers, where DDS Security is on. Fast
// DDS 2.9.1 keeps all that were ever given (its issue 4553): some 115 kB for each `takt status`, for ever.
// Not for other rooms.
#pragma once

namespace takt::dds {

/// From now on they are dropped once they have arrived, or who they were for has left. For the only
/// participant of this process; before it is made.
void drop_spent_tokens() noexcept;

}  // namespace takt::dds
