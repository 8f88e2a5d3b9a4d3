// takt force: replaces the samples of an input by a value, for a limited time and while this command runs.
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/client/answer_data.hpp>
#include <takt/client/connection.hpp>
#include <takt/client/port_names.hpp>
#include <takt/client/status.hpp>
#include <takt/client/user.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/signals.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "commands/ranges.hpp"
#include "commands/target.hpp"
#include "reports/page.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

using Json = nlohmann::ordered_json;
using std::chrono::milliseconds;

/// The node ends the force if it gets no renewal for 2 s.
constexpr Nanoseconds kRenewEvery = milliseconds{500};
constexpr Nanoseconds kAnswered = std::chrono::seconds{2};

struct ForceOptions {
  std::string port;
  std::vector<std::string> value;
  double seconds = 0;  ///< the longest duration
  bool end = false;
  client::Network network;
};

/// The value as the node expects it: an object, or a list of texts FIELD=VALUE.
std::string data_of(const std::vector<std::string>& value) {
  if (value.size() == 1 && value[0].starts_with('{')) return value[0];
  return model::json_text(Json(value));
}

/// Renews the force until its time is over, or until Ctrl-C. Returns the exit status.
int hold(client::Operator& sender, client::CommandRequest request, const std::string& port, Instant until,
         const os::SignalQueue& signals) {
  request.data.clear();
  Instant renewed = os::now();
  for (;;) {
    os::wait_readable({&signals.fd()}, 50);
    const Instant now = os::now();
    if (signals.next()) {
      request.kind = COMMAND_END_FORCE;
      if (const auto ended = client::accepted(sender.send(request)); !ended) return refuse(ended.problems());
      return print(port + " is no longer forced\n") ? 0 : 1;
    }
    if (now >= until) return print(port + " is no longer forced: its time is over\n") ? 0 : 1;
    // The last renewal lasts beyond the end.
    if (now < renewed + kRenewEvery || now + kRenewEvery >= until) continue;
    renewed = now;
    if (const auto longer = client::accepted(sender.send(request)); !longer) return refuse(longer.problems());
  }
}

int force(const ForceOptions& options) {
  const auto name = client::parse_port(options.port);
  if (!name)
    return refuse({fail(in_quotes(options.port) + " is not a port name", "write DEVICE.MODULE.PORT")});
  const auto signals = os::SignalQueue::of_requests_to_end();
  if (!signals) return refuse(signals.problems());
  const auto client = connect_to_device(options.network, name->device, name->module + "." + name->port);
  if (!client) return refuse(client.problems());
  const auto duration = std::chrono::round<Nanoseconds>(std::chrono::duration<double>(options.seconds));
  client::CommandRequest request{.kind = options.end ? COMMAND_END_FORCE : COMMAND_FORCE,
                                 .device = name->device,
                                 .module = name->module,
                                 .property = name->port,
                                 .value = client::user_at_machine(),
                                 .data = options.end ? "" : data_of(options.value),
                                 .time_ns = duration.count(),
                                 .limit = kAnswered};
  const auto answer = client::accepted(client->sender->send(request));
  if (!answer) return refuse(answer.problems());
  if (options.end) return print(options.port + " is no longer forced\n") ? 0 : 1;
  const Instant until = os::now() + duration;
  if (!print(fmt::format("{} is forced to {} for at most {}; Ctrl-C ends the force\n", options.port,
                         on_one_line(answer->data), to_text(duration))))
    return 1;
  return hold(*client->sender, std::move(request), options.port, until, *signals);
}

int list(const client::Network& network) {
  const auto client = client::connect(network);
  if (!client) return refuse(client.problems());
  const auto report = client::status(*client->sender);
  if (!report) return refuse(report.problems());
  std::vector<Page::Words> rows{{"input", "by", "seconds left", "value"}};
  for (const Json& device : report->at("devices")) {
    for (const Json& module : device.at("modules")) {
      for (const Json& port : module.value("ports", Json::array())) {
        if (!port.contains("forced")) continue;
        const Json& forced = port["forced"];
        rows.push_back({device.at("name").get<std::string>() + "." + module.at("name").get<std::string>() +
                            "." + port.at("name").get<std::string>(),
                        on_one_line(forced.at("by").get<std::string>()),
                        fmt::format("{:.0f}", forced.at("left_s").get<double>()),
                        on_one_line(model::json_text(forced.at("value")))});
      }
    }
  }
  if (rows.size() == 1) return print("no input is forced\n") ? 0 : 1;
  Page page{terminal_style()};
  page.table(0, rows);
  return print(std::move(page).take()) ? 0 : 1;
}

}  // namespace

void add_force(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<ForceOptions>();
  auto* command = app.add_subcommand(
      "force", "Make a module read a given value at an input, for a limited time; or list the forced inputs");
  auto* port = command->add_option("PORT", options->port,
                                   "DEVICE.MODULE.PORT, an input; without it, all forced inputs are listed");
  auto* value = command
                    ->add_option("VALUE", options->value,
                                 "FIELD=VALUE ..., with OUTER.INNER=VALUE for a nested field; or one JSON "
                                 "object. Fields that are left out are zero")
                    ->type_name("")
                    ->needs(port);
  auto* seconds =
      command->add_option("--for", options->seconds, "end the force after this many seconds, at most 3600")
          ->type_name("SECONDS")
          ->check(within(0.1, 3600))
          ->needs(value);
  value->needs(seconds);
  auto* end = command->add_flag("--end", options->end, "end the force of this input, whoever forces it")
                  ->needs(port)
                  ->excludes(value);
  add_network_options(*command, options->network);
  command->footer(
      "The force lasts while the command runs. It ends with Ctrl-C, when the time is over, when the node "
      "gets\n"
      "nothing from the command for 2 s, and when the module stops, is swapped or leaves EXECUTING.");
  command->callback([=, &chosen] {
    if (port->count() > 0 && value->count() == 0 && end->count() == 0)
      throw CLI::RequiredError("VALUE, or --end");
    chosen = [options] { return options->port.empty() ? list(options->network) : force(*options); };
  });
}

}  // namespace takt::tool
