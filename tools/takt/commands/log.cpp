// takt log: prints the events in the fault records of a cell's nodes.
#include <algorithm>
#include <cstdio>
#include <optional>

#include <nlohmann/json.hpp>

#include <takt/client/connection.hpp>
#include <takt/client/log.hpp>
#include <takt/core/words.hpp>
#include <takt/node/fault_record.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/signals.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "reports/log_report.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

struct LogOptions {
  std::string device;
  std::string module;
  std::string kinds;
  std::string since;
  std::optional<std::size_t> last;
  bool follow = false;
  bool json = false;
  std::string file;
  client::Network network;
};

/// Prints events as they arrive, and a line for each new day.
class Printer {
 public:
  explicit Printer(bool json) : json_(json) {}
  bool print(const std::vector<model::Fault>& events) {
    if (events.empty()) return true;
    return tool::print(json_ ? log_json(events) : log_text(events, day_, terminal_style()));
  }

 private:
  bool json_;
  std::string day_;
};

// The filter for these options, which are valid, because parsing the command line has checked them.
model::FaultFilter filter_of(const LogOptions& options) {
  model::FaultFilter filter{.device = options.device, .module = options.module, .last = options.last};
  if (!options.kinds.empty()) filter.kinds = *model::kinds_from(options.kinds);
  if (!options.since.empty()) filter.since_ns = *since_from(options.since, os::wall_ns());
  return filter;
}

void print_missing(const std::string& where, std::uint64_t overwritten, std::uint64_t damaged) {
  if (damaged != 0)
    std::fprintf(stderr, "%s: %llu damaged %s left out\n", where.c_str(),
                 static_cast<unsigned long long>(damaged), damaged == 1 ? "event was" : "events were");
  if (overwritten != 0)
    std::fprintf(stderr, "%s: %llu older %s no longer available\n", where.c_str(),
                 static_cast<unsigned long long>(overwritten), overwritten == 1 ? "event is" : "events are");
}

int log_of_file(const LogOptions& options) {
  const auto recorded = node::read_record_file(options.file);
  if (!recorded) {
    complain(recorded.problems());
    return 1;
  }
  const bool printed = Printer{options.json}.print(filter_of(options).of(recorded->events));
  print_missing(options.file, recorded->overwritten, recorded->damaged);
  return printed ? 0 : 1;
}

// If the filter matched nothing because the cell has no such module, returns the problem that says so.
std::optional<Problem> no_such_module(const LogOptions& options, const client::Observer& observer) {
  std::vector<std::string> names;
  for (const wire::ObservedDevice& seen : observer.devices()) {
    if (!options.device.empty() && seen.name() != options.device) continue;
    for (const auto& [name, status] : seen.deployment.modules) names.push_back(name);
  }
  if (names.empty() || std::find(names.begin(), names.end(), options.module) != names.end())
    return std::nullopt;
  return fail((options.device.empty() ? "no device" : "device " + options.device) + " has " +
                  (options.device.empty() ? "a" : "no") + " module " + in_quotes(options.module) +
                  ", and no fault record has an event of such a module",
              suggestion(options.module, {names.begin(), names.end()}));
}

int log(const LogOptions& options) {
  if (!options.file.empty()) return log_of_file(options);
  const auto signals =
      os::SignalQueue::of_requests_to_end();  // comes before other threads, which inherit the blocked signals
  if (!signals) {
    complain(signals.problems());
    return 1;
  }
  const auto client = client::connect(options.network);
  if (!client) {
    complain(client.problems());
    return 1;
  }
  std::unique_ptr<client::LogFollower> follower;
  if (options.follow) {
    auto created = client::LogFollower::create(client->participant);
    if (!created) {
      complain(created.problems());
      return 1;
    }
    follower = std::move(*created);
  }
  model::FaultFilter filter = filter_of(options);
  const client::Log read = client::read_log(*client->asker, filter);
  Printer printer{options.json};
  if (!printer.print(read.events)) return 1;
  for (const client::DeviceLog& device : read.devices)
    print_missing("device " + device.device, device.overwritten, device.damaged);
  complain(read.problems);
  if (!follower) {
    if (read.events.empty() && read.problems.empty() && !options.module.empty()) {
      if (const auto problem = no_such_module(options, *client->observer)) {
        complain({*problem});
        return 1;
      }
    }
    return read.problems.empty() ? 0 : 1;
  }
  follower->go_on_after(read);
  while (!signals->next()) {
    Problems problems;
    auto events = follower->next(*client->asker, std::chrono::milliseconds{100}, problems);
    std::erase_if(events, [&](const model::Fault& fault) { return !filter.takes(fault); });
    client::sort_by_time(events);
    if (!printer.print(events)) return 1;
    complain(problems);
  }
  return 0;
}

// The footer of the help: the kinds of events, wrapped to 100 columns.
std::string footer() {
  constexpr std::size_t kWidth = 100;
  std::string text = "Kinds:";
  std::size_t column = text.size();
  for (const std::string_view word : model::fault_words()) {
    const bool breaks = column + word.size() + 2 > kWidth;
    text += (breaks ? "\n" : " ") + std::string{word} + ",";
    column = (breaks ? 0 : column + 1) + word.size() + 1;
  }
  text.back() = '.';
  return text;
}

}  // namespace

void add_log(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<LogOptions>();
  auto* command = app.add_subcommand(
      "log", "Print the faults of a cell: errors, overruns, restarts, rejected commands and more");
  command->add_option("--device", options->device, "show only events of this device")->type_name("D");
  command->add_option("--module", options->module, "show only events of modules with this name")
      ->type_name("M");
  command
      ->add_option("--kind", options->kinds,
                   "show only events of these kinds: error, overrun, host-restart ...")
      ->type_name("K,...")
      ->check([](const std::string& text) {
        const auto kinds = model::kinds_from(text);
        return kinds ? std::string{} : in_words(kinds.problems());
      });
  command
      ->add_option(
          "--since", options->since,
          "show only events after this time: an age (90s, 10m, 2h, 7d) or a time (14:30, 2026-03-01T14:30)")
      ->type_name("TIME")
      ->check([](const std::string& text) {
        const auto since = since_from(text, os::wall_ns());
        return since ? std::string{} : in_words(since.problems());
      });
  command->add_option("--last", options->last, "show only the last N matching events")
      ->type_name("N")
      ->check(CLI::Range(0, 1000000).description(""));
  auto* follow =
      command->add_flag("--follow", options->follow, "continue to print events as they happen, until Ctrl-C");
  command->add_flag("--json", options->json, "print one JSON object per line");
  command
      ->add_option(
          "--file", options->file,
          "read the fault record from this file, for example if its node is not running; needs no network")
      ->type_name("FILE")
      ->excludes(follow);
  add_network_options(*command, options->network);
  command->footer(footer());
  command->callback([options, &chosen] { chosen = [options] { return log(*options); }; });
}

}  // namespace takt::tool
