// Lets a writer lose a reader without a deadlock. Only the source files of this room include this header.
//
// When a reader ends, Fast DDS 2.9.1 removes it from the writer, and then deletes the samples that all
// remaining readers have acknowledged, while it still holds the locks of the writer's destinations. If the
// thread that sends samples again has such a sample in its queue, the deletion waits for this thread, and
// this thread waits for the destinations. Then the participant handles no packets any more.
#pragma once

namespace takt::dds {

/// Finds the functions of Fast DDS that removed_readers.cpp replaces; ends the process if one is missing.
/// Call this function before the participant of this process is created.
void remove_readers_without_deadlock() noexcept;

}  // namespace takt::dds
