// Says which commands only read.
#pragma once

#include <takt/wire/takt.h>

namespace takt::wire {

/// Whether a command changes no module. Observers may send such a command, and it is answered even after its
/// deadline.
constexpr bool is_question(CommandKind kind) {
  return kind == COMMAND_REPORT || kind == COMMAND_DESCRIPTOR || kind == COMMAND_DESCRIBE ||
         kind == COMMAND_GET || kind == COMMAND_TAP || kind == COMMAND_LOG || kind == COMMAND_TRACE;
}

}  // namespace takt::wire
