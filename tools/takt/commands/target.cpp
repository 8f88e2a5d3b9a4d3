#include "commands/target.hpp"

#include <fmt/format.h>

#include <takt/client/target.hpp>
#include <takt/wire/words.hpp>

namespace takt::tool {

Result<Target> target_of(const std::string& text, const char* then) {
  const bool module_needed = then != nullptr;
  const std::size_t dot = text.find('.');
  Target target{text.substr(0, dot), dot == std::string::npos ? "" : text.substr(dot + 1)};
  const bool right = !target.device.empty() &&
                     (dot == std::string::npos ? !module_needed : !target.module.empty()) &&
                     target.module.find('.') == std::string::npos;
  if (!right) {
    return fail("'" + text + "' is not the name of a " + (module_needed ? "module" : "device or module"),
                module_needed ? fmt::format("write DEVICE.MODULE, a space and the {}", then)
                              : "write DEVICE or DEVICE.MODULE");
  }
  return target;
}

Result<Target> module_of(const std::string& text) {
  auto target = target_of(text);
  if (target && target->module.empty())
    return fail("'" + text + "' is the name of a device, not of a module", "write DEVICE.MODULE");
  return target;
}

Result<client::Connection> connect_to_device(const client::Network& network, const std::string& device,
                                             const std::string& rest) {
  auto client = client::connect(network);
  if (!client) return client.problems();
  if (const auto found = client::find_device(*client->sender, device, rest); !found) return found.problems();
  return client;
}

std::vector<CommandKind> steps_of_restart(const std::string& state) {
  if (state == to_text(STATE_IDLE)) return {COMMAND_INITIALIZE, COMMAND_START};
  if (state == to_text(STATE_DESTRUCT) || state.empty())
    return {COMMAND_RESET, COMMAND_INITIALIZE, COMMAND_START};
  return {COMMAND_DESTRUCT, COMMAND_RESET, COMMAND_INITIALIZE, COMMAND_START};
}

}  // namespace takt::tool
