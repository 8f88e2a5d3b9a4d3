#include <takt/client/tap.hpp>

#include <nlohmann/json.hpp>

#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/os/clock.hpp>

#include <takt/client/port_names.hpp>

namespace takt::client {

Result<dds::Flow> tapped(Operator& asker, const std::string& port) {
  const auto name = parse_port(port);
  if (!name) return fail(in_quotes(port) + " is not a port name", "write DEVICE.MODULE.PORT");
  const auto answer = accepted(asker.ask({.kind = COMMAND_TAP,
                                          .device = name->device,
                                          .module = name->module,
                                          .property = name->port,
                                          .time_ns = os::wall_ns() + Nanoseconds{kTapped}.count()}));
  if (!answer) return answer.problems();
  const auto place = model::parse_json(answer->data);
  if (!place.is_object()) return fail("the device runs another version of Takt: its answer cannot be read");
  if (place.contains("reply")) {
    return fail(port + " is a service", "call it with takt call " + port +
                                            "; to see its requests and replies, use takt echo with the "
                                            "client's ports NAME/request and NAME/reply");
  }
  auto type = model::parse_type(place.value("type", ""));
  if (!type) return type.problems();
  return dds::Flow{
      .topic = place.value("topic", ""),
      .type = std::move(*type),
      .quality = {.reliable = place.value("reliable", false), .depth = 64, .deadline = {}, .lifespan = {}}};
}

}  // namespace takt::client
