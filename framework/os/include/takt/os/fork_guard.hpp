// Ends a copy of this process that a module made with fork(), before the copy does the work of the original
// process.
#pragma once

#include <takt/core/result.hpp>

namespace takt::os {

/// After this call, is_forked_copy() and end_forked_copy() can distinguish this process from its copies. Call
/// it once.
Result<void> guard_against_forks();

/// Returns true if this process is a copy that fork() or daemon() made after guard_against_forks(). Reads one
/// word, so real-time threads may call it.
bool is_forked_copy() noexcept;

/// Ends this process at once, without exit handlers, if is_forked_copy(). Otherwise does nothing. Real-time
/// threads may call it.
void end_forked_copy() noexcept;

}  // namespace takt::os
