// Distinguishes questions, which only read, from commands that change a module.
#pragma once

#include <takt/wire/takt.h>

namespace takt::wire {

/// Returns true if a command is a question, which changes no module. Observers may ask questions. A node
/// answers a question even after the deadline of the command.
constexpr bool is_question(CommandKind kind) {
  return kind == COMMAND_REPORT || kind == COMMAND_DESCRIPTOR || kind == COMMAND_DESCRIBE ||
         kind == COMMAND_GET || kind == COMMAND_TAP || kind == COMMAND_LOG || kind == COMMAND_TRACE ||
         kind == COMMAND_ALARMS;
}

}  // namespace takt::wire
