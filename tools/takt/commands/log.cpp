// takt log: prints the events in the fault records of a cell's nodes.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <optional>

#include <nlohmann/json.hpp>

#include <takt/client/connection.hpp>
#include <takt/client/log.hpp>
#include <takt/core/words.hpp>
#include <takt/node/fault_record.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/files.hpp>
#include <takt/os/signals.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "commands/target.hpp"
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

/// How many events --follow prints first, unless --last or --since selects others.
constexpr std::size_t kFirstOfFollow = 10;

// Returns the filter for these options. The command line parser has checked that the options are valid.
model::FaultFilter filter_of(const LogOptions& options) {
  model::FaultFilter filter{.device = options.device, .module = options.module, .last = options.last};
  if (options.follow && !options.last && options.since.empty()) filter.last = kFirstOfFollow;
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
  auto events = filter_of(options).of(recorded->events);
  client::sort_by_time(events);
  const bool printed = Printer{options.json}.print(events);
  print_missing(options.file, recorded->overwritten, recorded->damaged);
  return printed ? 0 : 1;
}

// Explains why the filter matched no event: returns a problem if no running device has the module that the
// filter names.
std::optional<Problem> no_such_module(const LogOptions& options, const client::Observer& observer) {
  observer.settle(std::chrono::seconds{1});  // the states of the modules arrive after the device is found
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
  // Block the signals before any thread starts, because new threads inherit the set of blocked signals.
  const auto signals = os::SignalQueue::of_requests_to_end();
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
  const client::Log read = client::read_log(*client->sender, filter);
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
  // A node merges frequent events, and records a merged event up to a second after the time of the event. So
  // `takt log` holds each event for kHold, and then prints the events in the order of their times.
  constexpr Nanoseconds kHold = std::chrono::milliseconds{1200};
  struct Held {
    Instant since;
    model::Fault event;
  };
  std::vector<Held> held;
  const auto print_until = [&](Instant since) {
    std::vector<model::Fault> events;
    std::int64_t newest_ns = std::numeric_limits<std::int64_t>::min();
    for (const Held& each : held) {
      if (each.since <= since) newest_ns = std::max(newest_ns, each.event.time_ns);
    }
    std::erase_if(held, [&](Held& each) {
      if (each.event.time_ns > newest_ns) return false;
      events.push_back(std::move(each.event));
      return true;
    });
    client::sort_by_time(events);
    return printer.print(events);
  };
  while (!signals->next()) {
    Problems problems;
    auto events = follower->next(*client->sender, std::chrono::milliseconds{100}, problems);
    for (model::Fault& event : events) {
      if (filter.takes(event)) held.push_back({os::now(), std::move(event)});
    }
    if (!print_until(os::now() - kHold)) return 1;
    if (os::output_has_no_reader()) return kNoReader;
    complain(problems);
  }
  return print_until(os::now()) ? 0 : 1;
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
  auto target = std::make_shared<std::string>();
  command->add_option("TARGET", *target, "show only events of this DEVICE or DEVICE.MODULE");
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
  auto* follow = command->add_flag(
      "--follow", options->follow,
      "print the last 10 events, or those that --last or --since selects, and then new events "
      "as they happen, until Ctrl-C");
  command->add_flag("--json", options->json, "print one JSON object per line");
  command
      ->add_option(
          "--file", options->file,
          "read the fault record from this file, for example if its node is not running; needs no network")
      ->type_name("FILE")
      ->excludes(follow);
  add_network_options(*command, options->network);
  command->footer(footer());
  command->callback([options, target, &chosen] {
    chosen = [options, target] {
      if (target->empty()) return log(*options);
      const auto meant = target_of(*target);
      if (!meant) return refuse(meant.problems());
      if (!meant->module.empty() && !options->module.empty())
        return refuse(
            {fail("both " + in_quotes(*target) + " and --module name a module", "leave out one of them")});
      options->device = meant->device;
      if (!meant->module.empty()) options->module = meant->module;
      return log(*options);
    };
  });
}

}  // namespace takt::tool
