// Which commands only ask.
#pragma once

#include <takt/wire/takt.h>

namespace takt::dds {

/// What changes no module: it may be asked by whoever may look, and is answered also after its deadline.
constexpr bool is_question(CommandKind kind) {
  return kind == COMMAND_REPORT || kind == COMMAND_DESCRIPTOR || kind == COMMAND_DESCRIBE ||
         kind == COMMAND_GET || kind == COMMAND_TAP || kind == COMMAND_LOG || kind == COMMAND_TRACE;
}

}  // namespace takt::dds
