// Frees the keys (crypto tokens) that a participant with DDS Security sends to the readers and writers of
// each new participant. Fast DDS 2.9.1 never frees these keys (Fast DDS issue 4553): about 115 kB for each
// run of `takt status`. Only the source files of this room include this header.
#pragma once

namespace takt::dds {

/// Makes Fast DDS free keys when they have arrived, or when their receiver has left. Call this function
/// before the participant of this process is created.
void drop_spent_tokens() noexcept;

}  // namespace takt::dds
