// takt watch: shows every device and module of a DDS domain, live. On a terminal it is an interactive screen;
// otherwise it prints one line for each transition.
#include <algorithm>
#include <atomic>
#include <deque>
#include <functional>
#include <iterator>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include <fmt/format.h>

#include <takt/client/answer_data.hpp>
#include <takt/client/connection.hpp>
#include <takt/client/log.hpp>
#include <takt/core/words.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/files.hpp>
#include <takt/os/keyboard.hpp>
#include <takt/os/notice.hpp>
#include <takt/os/signals.hpp>
#include <takt/wire/words.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "commands/port_values.hpp"
#include "commands/ranges.hpp"
#include "commands/target.hpp"
#include "reports/run_report.hpp"
#include "terminal/screen_style.hpp"
#include "terminal/terminal.hpp"
#include "watch/screen.hpp"
#include "watch/watch_seen.hpp"

namespace takt::tool {

namespace {

struct WatchOptions {
  double seconds = 0;  ///< how long to watch; 0 means until q or Ctrl-C
  client::Network network;
};

/// The queue of events from the DDS threads to the main thread.
class News {
 public:
  struct Piece {
    std::string line;
    std::optional<LifecycleStatus> transition{};  ///< the transition that the line describes, if any
    std::optional<model::Fault> fault{};          ///< an event of a fault record; then there is no line
  };
  explicit News(os::Notice notice) : notice_(std::move(notice)) {}

  void add(Piece piece) {
    {
      const std::lock_guard lock{mutex_};
      if (pieces_.size() < kMost) pieces_.push_back(std::move(piece));
    }
    notice_.give();
  }
  std::deque<Piece> take() {
    notice_.take();
    const std::lock_guard lock{mutex_};
    return std::exchange(pieces_, {});
  }
  /// A file descriptor that is readable while the queue has events.
  [[nodiscard]] const os::Fd& fd() const noexcept { return notice_.fd(); }
  [[nodiscard]] const os::Notice& notice() const noexcept { return notice_; }

 private:
  os::Notice notice_;
  static constexpr std::size_t kMost = 10000;
  std::mutex mutex_;
  std::deque<Piece> pieces_;
};

std::string line_of(const LifecycleStatus& s) {
  const std::string text = s.text().to_string();
  return fmt::format("{} {}.{}: {} -> {}{}", watch::clock_text(s.time_ns()), s.device().to_string(),
                     s.name().to_string(), to_text(s.previous_state()),
                     state_text(to_text(s.state()), s.event() == EVENT_STOP),
                     text.empty() ? "" : " (" + on_one_line(text) + ")");
}

std::string line_of(const wire::ObservedDevice& device) {
  const DeviceStatus& s = device.status;
  const std::string text = s.text().to_string();
  std::string state = device.alive ? to_text(s.state()) : "LOST";
  if (device.alive && s.state() == DEVICE_RUNNING)
    state += fmt::format(", {} of {} modules EXECUTING", s.executing(), s.modules());
  return fmt::format("{} {}: {}{}", watch::clock_text(s.time_ns()), device.name(), state,
                     text.empty() ? "" : " (" + on_one_line(text) + ")");
}

int print_lines(const WatchOptions& options, const os::SignalQueue& signals, News& news) {
  const Instant end =
      os::now() + std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(options.seconds));
  while (options.seconds == 0 || os::now() < end) {
    os::wait_readable({&signals.fd(), &news.fd()}, 20);
    for (const News::Piece& piece : news.take()) {
      if (!print(piece.line + "\n")) return 1;
    }
    if (signals.next()) break;
    if (os::output_has_no_reader()) return kNoReader;
  }
  return 0;
}

/// The commands that carry out what the user wants, in order. `state` is the present state of the module.
std::vector<CommandKind> steps_of(watch::Verb verb, const std::string& state) {
  switch (verb) {
    case watch::Verb::initialize:
      return {COMMAND_INITIALIZE};
    case watch::Verb::start:
      return {COMMAND_START};
    case watch::Verb::stop:
      return {COMMAND_STOP};
    case watch::Verb::recover:
      return {COMMAND_RECOVER};
    case watch::Verb::reset:
      return {COMMAND_RESET};
    case watch::Verb::restart:
      return steps_of_restart(state);
    case watch::Verb::destruct:
      return {COMMAND_DESTRUCT};
  }
  return {};
}

/// Sends requests to nodes. An answer may take seconds. Each request has its own thread, so that the screen
/// does not wait for the answer.
class Requests {
 public:
  /// The object calls notice.give() when an answer arrives. `sender` and `notice` must outlive the object.
  Requests(client::Operator& sender, const os::Notice& notice) : sender_(sender), notice_(notice) {}
  Requests(const Requests&) = delete;
  Requests& operator=(const Requests&) = delete;
  ~Requests() {
    give_up_ = true;
    for (auto& one : open_) one->thread.join();
  }

  using Then = std::function<void(const Result<wire::WholeReply>&)>;
  /// Sends a request. When the answer has arrived, take_answers() calls `then` with it. Returns false if too
  /// many requests are unanswered.
  bool send(client::CommandRequest request, std::string words, Then then) {
    if (open_.size() >= kMost) return false;
    auto one = std::make_unique<Open>();
    one->words = std::move(words);
    one->since = os::now();
    one->then = std::move(then);
    one->thread = std::thread{[this, &open = *one, request = std::move(request)] {
      open.answer.emplace(sender_.send(std::vector{request}, [this] { return give_up_.load(); })[0]);
      open.done = true;  // synchronizes with take_answers(), which may read the answer from now on
      notice_.give();
    }};
    open_.push_back(std::move(one));
    return true;
  }
  /// Handles the answers that have arrived. Returns true if there was at least one.
  bool take_answers() {
    std::vector<std::unique_ptr<Open>> done;  // first taken out, because `then` may send another request
    const auto first_done = std::stable_partition(open_.begin(), open_.end(), [](const auto& one) {
      return !one->done;  // synchronizes with send()
    });
    std::move(first_done, open_.end(), std::back_inserter(done));
    open_.erase(first_done, open_.end());
    for (const auto& one : done) {
      one->thread.join();
      one->then(*one->answer);
    }
    return !done.empty();
  }
  /// The unanswered requests that the user has sent, with their age: "stop of robot.servo, 3 s".
  [[nodiscard]] std::vector<std::string> open() const {
    std::vector<std::string> all;
    for (const auto& one : open_) {
      if (one->words.empty()) continue;
      const auto seconds = std::chrono::floor<std::chrono::seconds>(os::now() - one->since).count();
      all.push_back(one->words + (seconds == 0 ? "" : fmt::format(", {} s", seconds)));
    }
    return all;
  }

 private:
  static constexpr std::size_t kMost = 16;
  struct Open {
    std::string words;
    Instant since{};
    Then then;
    std::optional<Result<wire::WholeReply>> answer{};
    std::atomic<bool> done{false};
    std::thread thread{};
  };
  client::Operator& sender_;
  const os::Notice& notice_;
  std::atomic<bool> give_up_{false};
  std::vector<std::unique_ptr<Open>> open_;
};

/// Reads the last faults of each device, and those that it records later. A node may be slow to answer, so
/// the faults have their own thread.
class Faults {
 public:
  /// `client` and `news` must outlive the object.
  Faults(const client::Connection& client, std::unique_ptr<client::LogFollower> follower, News& news)
      : client_(client), follower_(std::move(follower)), news_(news), thread_{[this] { run(); }} {}
  Faults(const Faults&) = delete;
  Faults& operator=(const Faults&) = delete;
  ~Faults() {
    ended_ = true;
    thread_.join();
  }

 private:
  static constexpr std::size_t kLast = 20;  // events that are read of each device
  void run() {
    std::set<std::string> read;
    while (!ended_) {
      for (const wire::ObservedDevice& device : client_.observer->devices()) {
        if (!device.alive || !read.insert(device.name()).second) continue;
        const client::Log log = client::read_log(*client_.sender, {.device = device.name(), .last = kLast},
                                                 [this] { return ended_.load(); });
        follower_->go_on_after(log);
        add(log.events);
      }
      Problems problems;
      add(follower_->next(*client_.sender, std::chrono::milliseconds{100}, problems));
    }
  }
  void add(const std::vector<model::Fault>& faults) {
    for (const model::Fault& fault : faults) news_.add({.line = "", .fault = fault});
  }

  const client::Connection& client_;
  std::unique_ptr<client::LogFollower> follower_;
  News& news_;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

/// The interactive screen of takt watch.
class Screen {
 public:
  Screen(const client::Connection& client, News& news)
      : news_(news), client_(client), watched_(client.domain), values_(client) {}

  int show(const os::SignalQueue& signals, double seconds);

 private:
  void take_news();
  void ask_for_descriptors(const std::vector<wire::ObservedDevice>& devices);
  void ask_for_components(const std::vector<wire::ObservedDevice>& devices);
  /// Adds to the snapshot the newest samples of the ports of the module whose details are shown.
  void add_values();
  /// Sends the first of the commands `steps`. When a command has succeeded, sends the next one.
  void send(const watch::Command& command, std::vector<CommandKind> steps);
  /// Handles all keys that were pressed. Returns false if the user wants to quit.
  bool press_keys();
  bool draw();

  News& news_;
  const client::Connection& client_;
  Watched watched_;
  PortValues values_;
  os::Keyboard keyboard_;
  watch::View view_;
  watch::Snapshot snapshot_;
  watch::Shown shown_;
  std::vector<std::string> on_terminal_;
  os::Keyboard::Size size_{};
  std::optional<Requests> requests_;
};

void Screen::take_news() {
  for (News::Piece& piece : news_.take()) {
    if (piece.transition) watched_.add(*piece.transition);
    if (piece.fault)
      watched_.add(*piece.fault);
    else
      watched_.add(piece.line);
  }
}

void Screen::ask_for_descriptors(const std::vector<wire::ObservedDevice>& devices) {
  const auto unknown = watched_.unknown(devices, os::now());
  if (!unknown) return;
  const client::CommandRequest request{.kind = COMMAND_DESCRIPTOR, .device = unknown->device};
  requests_->send(request, "", [this, id = unknown->deployment](const Result<wire::WholeReply>& answer) {
    if (!answer || answer->head.code() != REPLY_OK) return;
    auto cell = descriptor::parse(answer->data, answer->head.value().to_string());
    if (cell) watched_.add(id, std::make_shared<const model::Cell>(std::move(*cell)));
  });
}

void Screen::ask_for_components(const std::vector<wire::ObservedDevice>& devices) {
  const auto device = watched_.unreported(devices, os::now());
  if (!device) return;
  const client::CommandRequest request{.kind = COMMAND_REPORT, .device = *device};
  requests_->send(request, "", [this, name = *device](const Result<wire::WholeReply>& answer) {
    if (!answer || answer->head.code() != REPLY_OK) return;
    static_cast<void>(client::read_answer(name, answer->data, [&](const nlohmann::ordered_json& report) {
      watched_.add_components(name, components_in(client::checked_report(report)));
    }));
  });
}

void Screen::add_values() {
  std::vector<std::string> ports;
  const watch::Module* const module =
      view_.page == watch::Page::details ? snapshot_.module(view_.chosen) : nullptr;
  if (module != nullptr) {
    for (const watch::Port& port : module->ports) {
      if (!port.source.empty()) ports.push_back(port.source);
    }
  }
  values_.want(ports);
  snapshot_.values = values_.newest();
}

void Screen::send(const watch::Command& command, std::vector<CommandKind> steps) {
  const std::size_t dot = command.target.find('.');
  const std::string module = dot == std::string::npos ? "" : command.target.substr(dot + 1);
  const client::CommandRequest request{.kind = steps.front(),
                                       .device = command.target.substr(0, dot),
                                       .module = module,
                                       .limit = std::chrono::seconds{20}};
  steps.erase(steps.begin());
  const bool asked = requests_->send(
      request, fmt::format("{} of {}", to_text(command.verb), command.target),
      [this, command, module, steps = std::move(steps)](const Result<wire::WholeReply>& reply) {
        const auto answer = client::accepted(reply);
        if (answer && !steps.empty()) return send(command, steps);
        if (answer) {
          view_.message =
              command.target + ": " +
              (module.empty() ? "done for all modules"
                              : state_text(to_text(answer->head.state()), command.verb == watch::Verb::stop));
          return;
        }
        Problems problems = answer.problems();
        for (Problem& problem : problems)  // show DEVICE.MODULE instead of "device DEVICE"
          if (problem.where == "device " + command.target.substr(0, command.target.find('.')))
            problem.where = command.target;
        view_.message = in_words(problems);
      });
  if (!asked) view_.message = "not sent, because too many commands are unanswered";
}

bool Screen::press_keys() {
  while (const auto key = keyboard_.next()) {
    const watch::Done done = watch::press(view_, *key, shown_);
    if (done.quit) return false;
    if (done.command) {
      const watch::Module* const module = snapshot_.module(done.command->target);
      send(*done.command, steps_of(done.command->verb, module == nullptr ? "" : module->state));
    }
    // Draw after each key, because the effect of the next key may depend on what the screen shows.
    shown_ = watch::draw(snapshot_, view_, size_.columns, size_.rows, screen_style()).shown;
  }
  return true;
}

bool Screen::draw() {
  const auto size = keyboard_.size();
  if (size.columns != size_.columns || size.rows != size_.rows) on_terminal_.clear();
  size_ = size;
  snapshot_.commands = requests_->open();
  watch::Screen screen = watch::draw(snapshot_, view_, size.columns, size.rows, screen_style());
  shown_ = std::move(screen.shown);
  const std::string changes = watch::changes(on_terminal_, screen.lines);
  on_terminal_ = std::move(screen.lines);
  return changes.empty() || print_unchanged(changes);
}

int Screen::show(const os::SignalQueue& signals, double seconds) {
  constexpr std::chrono::milliseconds kLooks{
      200};  // interval at which the screen reads data that does not arrive as events
  const Instant begin = os::now();
  const Instant end = begin + std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(seconds));
  requests_.emplace(*client_.sender, news_.notice());
  // Switch to the alternate screen, hide the cursor, and turn line wrap off.
  static_cast<void>(print_unchanged("\033[?1049h\033[?25l\033[?7l"));
  const auto leave = [](int status) {
    static_cast<void>(print_unchanged("\033[?7h\033[?25h\033[?1049l"));
    return status;
  };
  Instant looked{};
  while (seconds == 0 || os::now() < end) {
    os::wait_readable({&signals.fd(), &keyboard_.fd(), &news_.fd()}, 50);
    if (signals.next()) return leave(0);
    take_news();
    const bool answered = requests_->take_answers();
    if (answered || os::now() - looked >= kLooks) {
      looked = os::now();
      const auto devices = client_.observer->devices();
      ask_for_descriptors(devices);
      ask_for_components(devices);
      snapshot_ = watched_.snapshot(devices, os::now());
      snapshot_.searching = os::now() - begin < client_.sender->search_limit();
      add_values();
    }
    if (!press_keys()) return leave(0);
    if (!draw()) return leave(1);
  }
  return leave(0);
}

int follow(const WatchOptions& options) {
  const auto refuse = [](const Problems& problems) {
    complain(problems);
    return 1;
  };
  const auto signals = os::SignalQueue::of_requests_to_end();
  if (!signals) return refuse(signals.problems());
  auto notice = os::Notice::create();
  if (!notice) return refuse(notice.problems());
  News news{std::move(*notice)};
  const auto client = client::connect(
      options.network, nullptr,
      {.news = {.module =
                    [&news](const LifecycleStatus& status) {
                      news.add({line_of(status), status});
                    },
                .device = [&news](const wire::ObservedDevice& device) { news.add({line_of(device)}); }},
       .statistics = true});
  if (!client) return refuse(client.problems());
  if (!os::Keyboard::is_terminal()) return print_lines(options, *signals, news);
  auto follower = client::LogFollower::create(client->participant);
  if (!follower) return refuse(follower.problems());
  Screen screen{*client, news};
  const Faults faults{*client, std::move(*follower), news};
  return screen.show(*signals, options.seconds);
}

}  // namespace

void add_watch(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<WatchOptions>();
  auto* command =
      app.add_subcommand("watch",
                         "Show every device and module live, with keys to start, stop and recover; if the "
                         "output is no terminal, print one line for each transition");
  command->add_option("--for", options->seconds, "end after this many seconds")
      ->type_name("SECONDS")
      ->check(within(0.0, 1e9));
  add_network_options(*command, options->network);
  command->callback([options, &chosen] { chosen = [options] { return follow(*options); }; });
}

}  // namespace takt::tool
