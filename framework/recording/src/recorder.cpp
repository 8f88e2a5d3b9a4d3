#include <takt/recording/recorder.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/client/operator.hpp>
#include <takt/core/words.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/files.hpp>
#include <takt/os/signals.hpp>

#include <takt/client/answer_data.hpp>
#include <takt/client/connection.hpp>
#include <takt/client/port_names.hpp>
#include <takt/recording/amounts.hpp>

namespace takt::recording {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Nanoseconds kTappedFor = seconds{30};     // the time for which a device publishes a port after one
                                                    // request
constexpr Nanoseconds kAskAgain = seconds{5};       // time between requests while all ports are present
constexpr Nanoseconds kLookAgain = seconds{1};      // time between requests while some ports are missing
constexpr Nanoseconds kAtOnce = milliseconds{100};  // time from a change of a device to the next request
constexpr Nanoseconds kAnswered = seconds{2};
constexpr Nanoseconds kExpandAgain = seconds{10};
constexpr std::uint32_t kDepth = 256;  // number of samples that DDS keeps for the recorder

class Recorder {
 public:
  Recorder(const RecordOptions& options, RecordingWriter& writer, const os::SignalQueue& signals,
           const client::Connection& client, std::atomic<bool>& news)
      : options_(options), writer_(writer), signals_(signals), client_(client), news_(news) {
    for (const std::string& name : options.ports) {
      if (!client::is_pattern(name)) sources_.try_emplace(name);
    }
  }

  void run() {
    const Instant begun = os::now();
    std::optional<Instant> end;
    if (options_.seconds) end = begun + Nanoseconds{static_cast<std::int64_t>(*options_.seconds * 1e9)};
    Instant again = begun;
    while (!ended_ && !(end && os::now() >= *end) && !writer_.health().full) {
      if (news_.exchange(false)) again = std::min(again, os::now() + kAtOnce);
      if (os::now() >= again) {
        look();
        const bool all = !sources_.empty() && std::all_of(sources_.begin(), sources_.end(),
                                                          [](const auto& s) { return s.second.tapped; });
        again = os::now() + (all ? kAskAgain : kLookAgain);
      }
      Nanoseconds wait = milliseconds{100};
      if (end) wait = std::clamp<Nanoseconds>(*end - os::now(), milliseconds{1}, wait);
      os::wait_readable({&signals_.fd()}, static_cast<int>(std::chrono::ceil<milliseconds>(wait).count()));
      should_end();
      progress(begun);
    }
    took_ = os::now() - begun;
  }

  [[nodiscard]] Nanoseconds took() const { return took_; }
  struct Recorded {
    std::string path;
    std::string type;
  };
  [[nodiscard]] const std::map<std::int64_t, Recorded>& recorded() const { return recorded_; }

  void say(const std::string& text) {
    if (options_.progress) options_.progress("");
    std::fprintf(stderr, "%s\n", on_one_line(options_.who + ": " + text).c_str());
  }

 private:
  struct Source {
    bool tapped = false;  ///< true if the device has accepted the last request for this port
    std::string topic;
    std::string type;
    bool reliable = false;
    std::string reported;  ///< the last reported reason why this port is not recorded yet
    std::unique_ptr<dds::Tap> tap;
  };

  bool should_end() {
    if (signals_.next()) ended_ = true;
    return ended_;
  }

  /// Asks the devices that are present to publish the wanted ports.
  void look() {
    std::map<std::string, wire::ObservedDevice> devices;
    for (wire::ObservedDevice& device : client_.observer->devices()) {
      if (device.alive) devices.insert_or_assign(device.name(), std::move(device));
    }
    expand(devices);
    if (looked_) report_unmatched(devices);
    looked_ = true;
    std::vector<client::CommandRequest> requests;
    std::vector<std::string> asked;
    for (auto& [path, source] : sources_) {
      const auto name = client::parse_port(path);
      const auto device = devices.find(name->device);
      if (device == devices.end()) {
        wait_for(path, source, "device " + name->device + " not found");
        continue;
      }
      requests.push_back({.kind = COMMAND_TAP,
                          .device = name->device,
                          .module = name->module,
                          .property = name->port,
                          .time_ns = os::wall_ns() + kTappedFor.count(),
                          .limit = kAnswered});
      asked.push_back(path);
    }
    auto answers = client_.sender->send(requests, [this] { return should_end(); });
    if (ended_) return;
    for (std::size_t i = 0; i < answers.size(); ++i) {
      Source& source = sources_.at(asked[i]);
      // A device that does not answer may be busy. The device continues to publish for 30 s after the last
      // request that it accepted.
      if (!answers[i] && source.tapped) continue;
      const auto answer = client::accepted(std::move(answers[i]));
      if (!answer) {
        wait_for(asked[i], source, in_words(answer.problems()));
        continue;
      }
      const std::string cell = devices.at(requests[i].device).status.cell().to_string();
      if (auto heard = listen(asked[i], source, answer->data, cell); !heard)
        wait_for(asked[i], source, in_words(heard.problems()));
    }
  }

  /// Finds the ports that match the patterns, for each new deployment of a device. Repeats the search every
  /// 10 s, because an update adds ports without changing the deployment's id.
  void expand(const std::map<std::string, wire::ObservedDevice>& devices) {
    std::vector<client::CommandRequest> requests;
    for (const auto& [name, device] : devices) {
      const std::string deployment = device.node() + "/" + device.status.deployment().to_string();
      const Expanded& last = expanded_[name];
      if (device.status.deployment().to_string().empty() ||
          (last.deployment == deployment && os::now() - last.at < kExpandAgain)) {
        continue;
      }
      if (std::none_of(options_.ports.begin(), options_.ports.end(),
                       [&of = name](const std::string& pattern) {
                         return client::is_pattern(pattern) && client::may_match(pattern, of);
                       }))
        continue;
      requests.push_back({.kind = COMMAND_REPORT, .device = name, .limit = kAnswered});
    }
    if (requests.empty()) return;
    auto answers = client_.sender->send(requests, [this] { return should_end(); });
    for (std::size_t i = 0; i < answers.size(); ++i) {
      const auto answer = client::accepted(std::move(answers[i]));
      if (!answer) continue;
      const std::string& device = requests[i].device;
      const auto read = client::read_answer(device, answer->data, [&](const nlohmann::ordered_json& report) {
        for (const auto& module : report.at("modules")) add_outputs(device, module);
        const wire::ObservedDevice& seen = devices.at(device);
        expanded_[device] = {seen.node() + "/" + seen.status.deployment().to_string(), os::now()};
      });
      if (!read) say(in_words(read.problems()));
    }
  }

  /// Reports, once, each pattern that no port matches.
  void report_unmatched(const std::map<std::string, wire::ObservedDevice>& devices) {
    for (const std::string& pattern : options_.ports) {
      if (!client::is_pattern(pattern) || std::any_of(sources_.begin(), sources_.end(), [&](const auto& s) {
            return client::matches(pattern, s.first);
          }))
        continue;
      std::string names;
      for (const auto& [name, device] : devices) names += (names.empty() ? "" : ", ") + name;
      if (unmatched_.insert(pattern).second)
        say("waits for an output port that matches '" + pattern + "'; " +
            (names.empty() ? "no device was found" : "devices found: " + names));
    }
  }

  void add_outputs(const std::string& device, const nlohmann::ordered_json& module) {
    if (!module.contains("ports")) return;
    for (const auto& port : module.at("ports")) {
      if (port.at("direction") != "out") continue;
      const std::string path =
          device + "." + module.at("name").get<std::string>() + "." + port.at("name").get<std::string>();
      const bool wanted =
          std::any_of(options_.ports.begin(), options_.ports.end(),
                      [&](const std::string& pattern) { return client::matches(pattern, path); });
      if (wanted) sources_.try_emplace(path);
    }
  }

  Result<void> listen(const std::string& path, Source& source, const std::string& data,
                      const std::string& cell) {
    bool is_service = false;
    std::string topic;
    std::string text;
    bool reliable = false;
    const auto read =
        client::read_answer(path.substr(0, path.find('.')), data, [&](const nlohmann::ordered_json& place) {
          is_service = place.contains("reply");
          topic = place.at("topic").get<std::string>();
          text = place.at("type").get<std::string>();
          reliable = place.at("reliable").get<bool>();
        });
    if (!read) return read.problems();
    if (is_service) return fail("it is a service", "record the client's NAME/request and NAME/reply");
    if (source.tap && topic == source.topic && text == source.type && reliable == source.reliable) {
      source.tapped = true;
      source.reported.clear();
      return {};
    }
    auto type = model::parse_type(text);
    if (!type) return type.problems();
    source.tap.reset();
    const RecordedPort port{path, topic, reliable, *type};
    const std::int64_t id = writer_.add_port(port, cell);
    const dds::Flow flow{
        .topic = topic,
        .type = *type,
        .quality = {.reliable = port.reliable, .depth = kDepth, .deadline = {}, .lifespan = {}}};
    auto tap = dds::Tap::create(
        client_.participant, flow,
        [this, id](const std::byte* bytes, std::size_t size, std::int64_t time_ns) {
          writer_.add(id, time_ns, bytes, size);
        },
        [this, id](std::uint64_t count) { writer_.miss(id, count); });
    if (!tap) return tap.problems();
    source = {.tapped = true,
              .topic = topic,
              .type = text,
              .reliable = reliable,
              .reported = {},
              .tap = std::move(*tap)};
    recorded_[id] = {path, type->name};
    say("records " + path + " (" + type->name + ")");
    return {};
  }

  void wait_for(const std::string& path, Source& source, const std::string& why) {
    source.tapped = false;
    if (std::exchange(source.reported, why) != why) say("waits for " + path + ": " + why);
  }

  void progress(Instant begun) {
    const RecordingHealth health = writer_.health();
    if (trouble_ != health.trouble) {
      say(health.trouble ? to_text(*health.trouble) + "; samples wait in the queue"
                         : "the disk accepts samples again");
      trouble_ = health.trouble;
    }
    const Instant now = os::now();
    if (!options_.progress || now - last_progress_ < seconds{1}) return;
    const double since = std::chrono::duration<double>(now - std::max(last_progress_, begun)).count();
    options_.progress(fmt::format(
        "{:.0f} s, {} ports, {} samples, {:.0f}/s, {}{}, {} lost",
        std::chrono::duration<double>(now - begun).count(), recorded_.size(), health.samples,
        static_cast<double>(health.samples - last_samples_) / since, bytes_text(health.bytes),
        health.dropped == 0 ? "" : fmt::format(", {} oldest samples dropped", health.dropped), health.lost));
    last_progress_ = now;
    last_samples_ = health.samples;
  }

  const RecordOptions& options_;
  RecordingWriter& writer_;
  const os::SignalQueue& signals_;
  const client::Connection& client_;
  std::atomic<bool>& news_;
  std::map<std::string, Source> sources_;  // the sources by path
  struct Expanded {
    std::string deployment;
    Instant at{};
  };
  std::map<std::string, Expanded> expanded_;   // the last result of expand() for each device
  std::map<std::int64_t, Recorded> recorded_;  // the recorded ports by port number in the file
  std::set<std::string> unmatched_;            // the reported patterns that match no port
  bool looked_ = false;  // true if the devices that were present at the start have been asked
  bool ended_ = false;
  Instant last_progress_{};
  std::uint64_t last_samples_ = 0;
  std::optional<Problem> trouble_;
  Nanoseconds took_{};
};

}  // namespace

int record(const RecordOptions& options) {
  const auto refuse = [&](const Problems& problems) {
    std::fprintf(stderr, "%s\n", to_text(problems).c_str());
    return 1;
  };
  if (const auto right = client::check_ports(options.ports); !right) return refuse(right.problems());
  const auto signals = os::SignalQueue::of_requests_to_end();
  if (!signals) return refuse(signals.problems());
  auto writer = RecordingWriter::create(options.recording);
  if (!writer) return refuse(writer.problems());

  std::atomic<bool> news{true};
  const auto client = client::connect(
      options.network, nullptr,
      {.news = {.module = {}, .device = [&news](const wire::ObservedDevice&) { news = true; }}});
  if (!client) return refuse(client.problems());
  client->observer->settle(seconds{1});
  Recorder recorder{options, **writer, *signals, *client, news};
  recorder.run();

  // Finish the file before the summary, because little time may remain before the process is killed.
  const std::string& file = options.recording.file;
  const auto finished = (*writer)->finish();
  const RecordingHealth health = (*writer)->health();
  if (health.full)
    recorder.say(on_one_line(file) + " has reached its limit of " + bytes_text(options.recording.max_bytes) +
                 "; the recording has ended");
  recorder.say(fmt::format(
      "{} samples of {} port{} in {:.1f} s, {} in {}; {} lost{}", health.samples, recorder.recorded().size(),
      recorder.recorded().size() == 1 ? "" : "s", std::chrono::duration<double>(recorder.took()).count(),
      bytes_text(health.bytes), on_one_line(file), health.lost,
      health.dropped == 0 ? "" : fmt::format(", {} oldest samples dropped", health.dropped)));
  const auto counts = (*writer)->counts();
  for (const auto& [id, port] : recorder.recorded()) {
    const auto count = counts.find(id);
    recorder.say(
        fmt::format("  {} ({}): {}", port.path, port.type, count == counts.end() ? 0 : count->second));
  }
  if (!finished) return refuse(finished.problems());
  if (!recorder.recorded().empty()) return 0;
  if (!options.recording.append) {  // otherwise the next attempt would fail, because the empty file exists
    writer->reset();
    std::error_code error;
    const auto itself = std::filesystem::canonical(file, error);  // if `file` is a link, the link stays
    if (const auto removed = os::remove_file(itself.string()); !removed) return refuse(removed.problems());
  }
  return 1;
}

}  // namespace takt::recording
