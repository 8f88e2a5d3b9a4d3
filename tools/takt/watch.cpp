// takt watch: every device and module of a domain, live. In a terminal a screen with keys; else a line for
// each transition.
#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <deque>
#include <mutex>

#include <fmt/format.h>

#include <takt/core/words.hpp>
#include <takt/dds/words.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/keyboard.hpp>
#include <takt/os/notice.hpp>
#include <takt/os/signals.hpp>

#include "client.hpp"
#include "commands.hpp"
#include "load.hpp"
#include "ranges.hpp"
#include "terminal.hpp"
#include "watch_report.hpp"

namespace takt::tool {

namespace {

struct WatchOptions {
  double seconds = 0;  ///< 0: until q or Ctrl-C
  Network network;
};

/// What goes on, from the threads of DDS to ours.
class Lines {
 public:
  explicit Lines(os::Notice notice) : notice_(std::move(notice)) {}

  void add(std::string line) {
    {
      const std::lock_guard lock{mutex_};
      if (lines_.size() < kMost) lines_.push_back(std::move(line));
    }
    notice_.give();
  }
  std::deque<std::string> take() {
    notice_.take();
    const std::lock_guard lock{mutex_};
    return std::exchange(lines_, {});
  }
  /// Can be read when there is something to take.
  [[nodiscard]] const os::Fd& fd() const noexcept { return notice_.fd(); }

 private:
  os::Notice notice_;
  static constexpr std::size_t kMost = 100000;
  std::mutex mutex_;
  std::deque<std::string> lines_;
};

std::string line_of(const LifecycleStatus& s) {
  const std::string text = s.text().to_string();
  return fmt::format("{} {}.{}: {} -> {}{}\n", clock_text(s.time_ns()), s.device().to_string(),
                     s.name().to_string(), to_text(s.previous_state()), to_text(s.state()),
                     text.empty() ? "" : " (" + on_one_line(text) + ")");
}

std::string line_of(const dds::SeenDevice& device) {
  const DeviceStatus& s = device.status;
  const std::string text = s.text().to_string();
  std::string state = device.alive ? to_text(s.state()) : "LOST";
  if (device.alive && s.state() == DEVICE_RUNNING)
    state += fmt::format(", {} of {} modules EXECUTING", s.executing(), s.modules());
  return fmt::format("{} {}: {}{}\n", clock_text(s.time_ns()), device.name(), state,
                     text.empty() ? "" : " (" + on_one_line(text) + ")");
}

int print_lines(const WatchOptions& options, const os::SignalQueue& signals, const Client&, Lines& lines) {
  const Instant end =
      os::now() + std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(options.seconds));
  while (options.seconds == 0 || os::now() < end) {
    os::wait_readable({&signals.fd(), &lines.fd()}, 20);
    for (const std::string& line : lines.take()) {
      if (!print(line)) return 1;
    }
    if (signals.next()) break;
  }
  return 0;
}

std::vector<WatchRow> watch_rows(const std::vector<dds::SeenDevice>& devices) {
  std::vector<WatchRow> rows;
  for (const dds::SeenDevice& device : devices) {
    WatchRow row;
    row.device = device.name();
    row.state = to_text(device.status.state());
    row.lost = !device.alive;
    row.text = device.status.text().to_string();
    rows.push_back(row);
    for (const auto& [name, status] : device.deployment.modules) {
      WatchRow module;
      module.device = row.device;
      module.module = name;
      module.state = to_text(status.state());
      module.lost = row.lost;
      if (status.state() == STATE_RECOVER || status.state() == STATE_DESTRUCT)
        module.text = status.text().to_string();
      if (const auto found = device.deployment.statistics.find(name);
          found != device.deployment.statistics.end()) {
        const ModuleStatistics& measured = found->second;
        module.measured = true;
        module.cycles = measured.cycles();
        module.jitter_p50_us = measured.jitter_us().p50();
        module.jitter_p99_us = measured.jitter_us().p99();
        module.overruns = measured.overruns();
        module.errors = measured.errors();
      }
      rows.push_back(module);
    }
  }
  return rows;
}

/// A verb that a key stands for.
std::optional<CommandKind> verb_of(char key) {
  switch (key) {
    case 's':
      return COMMAND_START;
    case 't':
      return COMMAND_STOP;
    case 'r':
      return COMMAND_RECOVER;
    case 'x':
      return COMMAND_RESET;
    case 'i':
      return COMMAND_INITIALIZE;
    default:
      return std::nullopt;
  }
}

int show_screen(const WatchOptions& options, const os::SignalQueue& signals, const Client& client,
                Lines& lines) {
  os::Keyboard keyboard;
  const Instant end =
      os::now() + std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(options.seconds));
  WatchScreen screen{.selected = 0, .message = {}, .events = {}};
  Instant drawn{};
  std::string shown;
  static_cast<void>(print("\033[?1049h\033[?25l"));  // a screen of its own, without a cursor
  const auto leave = [](int status) {
    static_cast<void>(print("\033[?25h\033[?1049l"));
    return status;
  };
  while (options.seconds == 0 || os::now() < end) {
    os::wait_readable({&signals.fd(), &keyboard.fd(), &lines.fd()}, 100);
    if (signals.next()) return leave(0);
    bool changed = false;
    for (const std::string& line : lines.take()) {
      screen.events.push_back(line.substr(0, line.size() - 1));
      if (screen.events.size() > 8) screen.events.pop_front();
      changed = true;
    }
    const auto rows = watch_rows(client.observer->devices());
    while (const auto key = keyboard.next()) {
      changed = true;
      if (*key == 'q') return leave(0);
      if (*key == os::Keyboard::kUp && screen.selected > 0) --screen.selected;
      if (*key == os::Keyboard::kDown) ++screen.selected;
      const auto verb = verb_of(*key);
      if (!verb || rows.empty()) continue;
      const WatchRow& row = rows[std::min(screen.selected, rows.size() - 1)];
      const auto answer = client::accepted(client.asker->ask(
          {.kind = *verb, .device = row.device, .module = row.module, .limit = std::chrono::seconds{10}}));
      screen.message =
          answer ? row.target() + ": " + (row.module.empty() ? "all do it" : to_text(answer->head.state()))
                 : in_words(answer.problems());
    }
    if (!rows.empty()) screen.selected = std::min(screen.selected, rows.size() - 1);
    if (!changed && os::now() - drawn < std::chrono::milliseconds{200}) continue;
    drawn = os::now();
    const auto size = keyboard.size();
    std::string next = watch_screen(rows, screen, size.columns, size.rows, terminal_style());
    if (next == shown) continue;
    shown = std::move(next);
    if (!print("\033[H" + shown)) return leave(1);
  }
  return leave(0);
}

int watch(const WatchOptions& options) {
  const auto refuse = [](const Problems& problems) {
    complain(problems);
    return 1;
  };
  const auto signals = os::SignalQueue::of_requests_to_end();
  if (!signals) return refuse(signals.problems());
  auto notice = os::Notice::create();
  if (!notice) return refuse(notice.problems());
  Lines lines{std::move(*notice)};
  const auto client =
      connect(options.network, nullptr,
              {.news = {.module = [&lines](const LifecycleStatus& status) { lines.add(line_of(status)); },
                        .device = [&lines](const dds::SeenDevice& device) { lines.add(line_of(device)); }},
               .statistics = true});
  if (!client) return refuse(client.problems());
  return os::Keyboard::is_terminal() ? show_screen(options, *signals, *client, lines)
                                     : print_lines(options, *signals, *client, lines);
}

}  // namespace

void add_watch(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<WatchOptions>();
  auto* command = app.add_subcommand("watch",
                                     "Show every device and module live, with keys to start, stop and "
                                     "recover; not in a terminal, a line for each "
                                     "transition");
  command->add_option("--for", options->seconds, "end after this long")
      ->type_name("SECONDS")
      ->check(within(0.0, 1e9));
  add_network_options(*command, options->network);
  command->callback([options, &chosen] { chosen = [options] { return watch(*options); }; });
}

}  // namespace takt::tool
