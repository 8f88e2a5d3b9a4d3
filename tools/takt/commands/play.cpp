// takt play: publishes the samples of a recording to a cell again, with their original timing.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <takt/client/connection.hpp>
#include <takt/client/identity.hpp>
#include <takt/core/words.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/files.hpp>
#include <takt/os/signals.hpp>
#include <takt/recording/amounts.hpp>
#include <takt/recording/reader.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "commands/ranges.hpp"
#include "reports/page.hpp"
#include "terminal/progress.hpp"
#include "terminal/screen_style.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

using std::chrono::milliseconds;

constexpr Nanoseconds kReadersFound =
    std::chrono::seconds{3};                           // time to find readers before the first sample
constexpr Nanoseconds kDelivered = milliseconds{200};  // time to deliver the last samples before the end
constexpr Nanoseconds kLook = milliseconds{50};        // interval of the checks for Ctrl-C
constexpr std::uint32_t kDepth = 256;

struct PlayOptions {
  std::string file;
  bool list = false;
  double speed = 1;
  std::optional<double> from;
  std::optional<double> to;
  bool loop = false;
  std::vector<std::string> ports;  ///< the ports to play, as PATH[=TOPIC]; if empty, all ports
  client::Network network;
};

std::int64_t in_ns(double s) { return static_cast<std::int64_t>(std::llround(s * 1e9)); }

int print_recording(const recording::Recording& recording, const std::string& file) {
  Page page{terminal_style()};
  const double length = static_cast<double>(recording.last_ns() - recording.first_ns()) / 1e9;
  page.heading(0, on_one_line(file),
               recording.cell().empty() ? "no samples yet" : "cell " + recording.cell());
  if (recording.samples() > 0) {
    page.line(0, fmt::format("{} samples in {:.3f} s, from {}", recording.samples(), length,
                             recording::date_text(recording.first_ns())));
  }
  page.blank();
  std::vector<Page::Words> rows{{"port", "type", "samples", "missing", "from s", "to s"}};
  for (const recording::PortOfRecording& port : recording.ports()) {
    const auto at = [&](std::int64_t time_ns) {
      return port.samples == 0
                 ? "-"
                 : fmt::format("{:.3f}", static_cast<double>(time_ns - recording.first_ns()) / 1e9);
    };
    rows.push_back({port.path, port.type.name, std::to_string(port.samples), std::to_string(port.missing),
                    at(port.first_ns), at(port.last_ns)});
  }
  page.table(0, rows);
  return print(std::move(page).take()) ? 0 : 1;
}

/// The topic of each port to play, by the port's number in the recording.
Result<std::map<std::int64_t, std::string>> chosen_ports(const recording::Recording& recording,
                                                         const PlayOptions& options,
                                                         const recording::Selection& time) {
  std::map<std::int64_t, std::string> topics;
  Problems problems;
  const auto add = [&](const recording::PortOfRecording& port, const std::string& topic) {
    if (port.samples > 0 && port.last_ns >= time.from_ns && port.first_ns <= time.to_ns)
      topics[port.id] = topic;
  };
  std::vector<std::string_view> known;
  for (const recording::PortOfRecording& port : recording.ports()) {
    known.emplace_back(port.path);
    if (options.ports.empty()) add(port, port.topic);
  }
  for (const std::string& text : options.ports) {
    const std::size_t equal = text.find('=');
    const std::string path = text.substr(0, equal);
    const std::string topic = equal == std::string::npos ? "" : text.substr(equal + 1);
    if (equal != std::string::npos && topic.empty())
      problems.push_back(
          fail(in_quotes(text) + " has no topic after '='", "write PATH=TOPIC, or PATH alone"));
    bool found = false;
    for (const recording::PortOfRecording& port : recording.ports()) {
      if (port.path != path) continue;
      found = true;
      add(port, topic.empty() ? port.topic : topic);
    }
    if (!found)
      problems.push_back(fail("has no port " + in_quotes(path),
                              known.empty() ? "the recording has no ports" : suggestion(path, known)));
  }
  // Check that each topic has only one type and one port.
  for (auto a = topics.begin(); a != topics.end(); ++a) {
    for (auto b = std::next(a); b != topics.end(); ++b) {
      if (a->second != b->second) continue;
      const auto port_of = [&](std::int64_t id) -> const recording::PortOfRecording& {
        return *std::find_if(recording.ports().begin(), recording.ports().end(),
                             [&](const auto& port) { return port.id == id; });
      };
      const recording::PortOfRecording& one = port_of(a->first);
      const recording::PortOfRecording& other = port_of(b->first);
      if (one.path == other.path && one.type == other.type) continue;
      problems.push_back(one.path == other.path
                             ? fail("port " + one.path + " has samples of two types in the recording",
                                    "choose the samples of one type with --from and --to; see --list")
                             : fail("ports " + one.path + " and " + other.path +
                                        " would both be played to topic " + a->second,
                                    "give each port its own topic with --port PATH=TOPIC"));
    }
  }
  if (problems.empty() && topics.empty())
    problems.push_back(fail("has no samples between --from and --to", "see --list"));
  if (!problems.empty()) {
    for (Problem& problem : problems) problem.where = on_one_line(options.file);
    return problems;
  }
  return topics;
}

/// Fails if a running module writes one of the topics, because its readers would get samples of two writers.
Result<void> check_no_other_writer(const client::Connection& client, const recording::Recording& recording,
                                   const std::map<std::int64_t, std::string>& topics) {
  client.observer->settle(std::chrono::seconds{1});
  Problems problems;
  for (const recording::PortOfRecording& port : recording.ports()) {
    const auto topic = topics.find(port.id);
    if (topic == topics.end()) continue;
    for (const wire::ObservedDevice& device : client.observer->devices()) {
      if (!device.alive) continue;
      for (const auto& [name, module] : device.deployment.modules) {
        const std::string of_module =
            "takt/" + device.status.cell().to_string() + "/" + device.name() + "/" + name + "/";
        if (module.state() != STATE_EXECUTING || topic->second.rfind(of_module, 0) != 0) continue;
        problems.push_back({"port " + port.path,
                            "is written by " + device.name() + "." + name + ", which is running",
                            "stop the module, or play to another topic: --port " + port.path + "=TOPIC"});
      }
    }
  }
  if (problems.empty()) return {};
  return problems;
}

struct Played {
  std::uint64_t samples = 0;
  std::uint64_t rejected = 0;  ///< samples that DDS rejected
  std::uint64_t wrong = 0;     ///< samples that are damaged in the recording
  Nanoseconds latest{0};       ///< the longest delay of a sample
};

class Player {
 public:
  Player(recording::Recording& recording, const PlayOptions& options, recording::Selection selection,
         const os::SignalQueue& signals, std::map<std::int64_t, std::shared_ptr<dds::Feed>> feeds)
      : recording_(recording),
        options_(options),
        selection_(std::move(selection)),
        signals_(signals),
        feeds_(std::move(feeds)) {}

  Result<void> run() {
    const std::int64_t first = std::max(selection_.from_ns, recording_.first_ns());
    const std::int64_t last = std::min(selection_.to_ns, recording_.last_ns());
    length_ = static_cast<double>(last - first) / 1e9;
    const Nanoseconds round = std::max<Nanoseconds>(scaled(last - first), milliseconds{1});
    begun_ = os::now() + milliseconds{10};
    // Compute the time of every sample from the beginning of the round, so that delays do not add up.
    for (Instant begin = begun_;; begin += round) {
      const auto done = recording_.read(
          selection_,
          [&](const recording::RecordedSample& sample) {
            const Instant due = begin + scaled(sample.time_ns - first);
            if (!wait_until(due, sample.time_ns - first)) return false;
            played_.latest = std::max<Nanoseconds>(played_.latest, os::now() - due);
            if (feeds_.at(sample.port->id)->write(sample.bytes, sample.size))
              ++played_.samples;
            else
              ++played_.rejected;
            return true;
          },
          played_.wrong);
      if (!done) return done;
      if (ended_ || !options_.loop) break;
      if (!wait_until(begin + round, last - first)) break;
    }
    os::sleep_until(os::now() + kDelivered);
    progress_.clear();
    return {};
  }
  [[nodiscard]] const Played& played() const { return played_; }

 private:
  [[nodiscard]] Nanoseconds scaled(std::int64_t ns) const {
    return Nanoseconds{static_cast<std::int64_t>(std::llround(static_cast<double>(ns) / options_.speed))};
  }
  /// Waits until `due`, and updates the progress line meanwhile. Returns false if the user asked to end.
  bool wait_until(Instant due, std::int64_t at_ns) {
    for (;;) {
      const Instant now = os::now();
      if (now >= looked_ + kLook || due > now + kLook) {
        looked_ = now;
        if (signals_.next()) ended_ = true;
        if (ended_) return false;
        progress(at_ns);
      }
      if (due <= now) return true;
      if (due <= now + kLook) {
        os::sleep_until(due);
        return true;
      }
      os::wait_readable({&signals_.fd()}, static_cast<int>(milliseconds{kLook / milliseconds{1}}.count()));
    }
  }
  void progress(std::int64_t at_ns) {
    if (!progress_.is_due()) return;
    const double at = static_cast<double>(at_ns) / 1e9;
    progress_.show(share_text(length_ > 0 ? at / length_ : 1,
                              fmt::format("{:.1f} of {:.1f} s, {} samples", at, length_, played_.samples),
                              {.unicode = is_utf8()}));
  }

  recording::Recording& recording_;
  const PlayOptions& options_;
  const recording::Selection selection_;
  const os::SignalQueue& signals_;
  std::map<std::int64_t, std::shared_ptr<dds::Feed>> feeds_;
  Progress progress_;
  Played played_;
  double length_ = 0;
  Instant begun_{};
  Instant looked_{};
  bool ended_ = false;
};

/// Waits until each topic has a reader, but not longer than kReadersFound. Then reports each topic without a
/// reader. The samples of such a topic are published too, because a reader may appear later.
void wait_for_readers(const std::map<std::int64_t, std::shared_ptr<dds::Feed>>& feeds,
                      const std::map<std::int64_t, std::string>& topics, const os::SignalQueue& signals) {
  const auto read = [&](std::int64_t id) { return feeds.at(id)->health().matched > 0; };
  const Instant until = os::now() + kReadersFound;
  while (os::now() < until &&
         !std::all_of(feeds.begin(), feeds.end(), [&](const auto& f) { return read(f.first); }))
    if (os::wait_readable({&signals.fd()}, 20)) return;
  for (const auto& [id, topic] : topics) {
    if (read(id)) continue;
    const std::string why = feeds.at(id)->health().incompatible;
    tell("takt play: topic " + topic + " has no reader" +
         (why.empty() ? "" : ": its readers require another " + why));
  }
}

int play(const PlayOptions& options) {
  const auto refuse = [](const Problems& problems) {
    complain(problems);
    return 1;
  };
  auto recording = recording::Recording::open(options.file);
  if (!recording) return refuse(recording.problems());
  if (options.list) return print_recording(*recording, options.file);

  recording::Selection selection;
  const std::int64_t first = recording->first_ns();
  if (options.from) selection.from_ns = first + in_ns(*options.from);
  if (options.to) selection.to_ns = first + in_ns(*options.to);
  if (selection.from_ns > selection.to_ns) return refuse({fail("--from is after --to", "")});
  const auto topics = chosen_ports(*recording, options, selection);
  if (!topics) return refuse(topics.problems());
  for (const auto& [id, topic] : *topics) selection.ports.insert(id);

  const auto signals = os::SignalQueue::of_requests_to_end();
  if (!signals) return refuse(signals.problems());
  const auto client = client::connect(options.network);
  if (!client) return refuse(client.problems());
  if (const auto may = client::may_write(*client->participant, "play"); !may) return refuse(may.problems());
  if (const auto free = check_no_other_writer(*client, *recording, *topics); !free)
    return refuse(free.problems());

  std::map<std::int64_t, std::shared_ptr<dds::Feed>> feeds;
  std::map<std::string, std::shared_ptr<dds::Feed>> by_topic;
  for (const recording::PortOfRecording& port : recording->ports()) {
    const auto topic = topics->find(port.id);
    if (topic == topics->end()) continue;
    auto& feed = by_topic[topic->second];
    if (!feed) {
      // The writer is reliable, because a reliable writer matches both reliable and best-effort readers.
      auto made =
          dds::Feed::create(client->participant,
                            {.topic = topic->second,
                             .type = port.type,
                             .quality = {.reliable = true, .depth = kDepth, .deadline = {}, .lifespan = {}}});
      if (!made) return refuse(made.problems());
      feed = std::move(*made);
    }
    feeds[port.id] = feed;
  }
  wait_for_readers(feeds, *topics, *signals);

  Player player{*recording, options, selection, *signals, feeds};
  const auto done = player.run();
  const Played& played = player.played();
  std::fprintf(
      stderr, "takt play: %s\n",
      fmt::format("{} samples of {} port{}, at most {:.1f} ms late{}{}", played.samples, topics->size(),
                  topics->size() == 1 ? "" : "s",
                  std::chrono::duration<double, std::milli>(played.latest).count(),
                  played.rejected == 0 ? "" : fmt::format("; DDS rejected {}", played.rejected),
                  played.wrong == 0 ? "" : fmt::format("; left out {} damaged samples", played.wrong))
          .c_str());
  if (!done) return refuse(done.problems());
  return played.rejected == 0 && played.wrong == 0 ? 0 : 1;
}

}  // namespace

void add_play(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<PlayOptions>();
  auto* command = app.add_subcommand(
      "play", "Publish the samples of a recording to a cell again, or list the contents of a recording");
  command->add_option("FILE", options->file, "a recording made by takt record")->required();
  command->add_flag("--list", options->list,
                    "list the recorded ports with their types, samples and times, and play nothing");
  command->add_option("--speed", options->speed, "play X times as fast as recorded")
      ->type_name("X")
      ->check(within(0.001, 1000))
      ->capture_default_str();
  command
      ->add_option("--from", options->from, "begin this many seconds after the first sample of the recording")
      ->type_name("SECONDS")
      ->check(within(0, 1e9));
  command->add_option("--to", options->to, "end this many seconds after the first sample of the recording")
      ->type_name("SECONDS")
      ->check(within(0, 1e9));
  command->add_flag("--loop", options->loop, "repeat the recording until Ctrl-C");
  command
      ->add_option("--port", options->ports,
                   "play only this port, to its original topic or to TOPIC; may be repeated")
      ->type_name("PATH[=TOPIC]")
      ->allow_extra_args(false);
  add_network_options(*command, options->network);
  command->callback([options, &chosen] { chosen = [options] { return play(*options); }; });
}

}  // namespace takt::tool
