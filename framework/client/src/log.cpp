#include <takt/client/log.hpp>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/client/answer_data.hpp>
#include <takt/client/target.hpp>
#include <takt/dds/topics.hpp>
#include <takt/model/json.hpp>
#include <takt/wire/fault.hpp>
#include <takt/wire/judgement.hpp>
#include "reports.hpp"

namespace takt::client {

namespace {

using Clock = std::chrono::steady_clock;
using json = nlohmann::ordered_json;

/// A node sends its latest events to each new reader. These events arrive within this time after the node's
/// discovery.
constexpr std::chrono::seconds kLastEvents{3};

CommandRequest request_of(const std::string& device, const model::FaultFilter& filter) {
  return {.kind = COMMAND_LOG, .device = device, .data = model::json_text(model::to_json(filter))};
}

// Adds the problems in `more` that are not in `problems` yet. If two nodes have the same device name, every
// request to this device fails with the same problem.
void add_new(Problems& problems, const Problems& more) {
  for (const Problem& problem : more) {
    if (std::find(problems.begin(), problems.end(), problem) == problems.end()) problems.push_back(problem);
  }
}

// Adds the events in a node's answer to `log`. If `missed` is not null, adds the devices that the node has
// lost to `*missed`.
void add_events_of(Log& log, const std::string& device, const wire::WholeReply& reply,
                   std::set<std::string>* missed) {
  DeviceLog own;
  std::vector<model::Fault> events;
  std::set<std::string> lost;
  const auto read = read_answer(device, reply.data, [&](const json& value) {
    own = {.device = device,
           .file = value.at("file").is_null() ? "" : value.at("file").get<std::string>(),
           .newest = value.at("newest"),
           .newest_time_ns = value.at("newest_time_ns"),
           .overwritten = value.at("overwritten"),
           .damaged = value.at("damaged")};
    for (const json& event : value.at("events")) {
      auto fault = model::fault_from(event);
      if (!fault) throw std::invalid_argument{"no event"};
      events.push_back(std::move(*fault));
    }
    lost = value.at("lost").get<std::set<std::string>>();
  });
  if (!read) return add_new(log.problems, read.problems());
  log.devices.push_back(std::move(own));
  log.events.insert(log.events.end(), events.begin(), events.end());
  if (missed != nullptr) missed->insert(lost.begin(), lost.end());
}

}  // namespace

void sort_by_time(std::vector<model::Fault>& events) {
  std::stable_sort(events.begin(), events.end(),
                   [](const auto& a, const auto& b) { return a.sequence < b.sequence; });
  struct Device {
    std::int64_t newest_ns = std::numeric_limits<std::int64_t>::min();
    std::int64_t set_back_ns = 0;  // the time by which the clock of the device has been set back
  };
  std::map<std::string, Device> devices;
  std::vector<std::pair<std::int64_t, model::Fault>> placed;
  for (model::Fault& event : events) {
    Device& device = devices[event.device];
    // An event is recorded at most about a second after its time. So a larger backward step means that the
    // clock was set back.
    constexpr std::int64_t kStep = 2'000'000'000;
    std::int64_t at = event.time_ns + device.set_back_ns;
    if (device.newest_ns > at + kStep) {
      device.set_back_ns += device.newest_ns - at;
      at = device.newest_ns;
    }
    device.newest_ns = std::max(device.newest_ns, at);
    placed.emplace_back(at, std::move(event));
  }
  std::stable_sort(placed.begin(), placed.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  events.clear();
  for (auto& [at, event] : placed) events.push_back(std::move(event));
}

Log read_log(Operator& sender, const model::FaultFilter& filter, const std::function<bool()>& give_up) {
  std::set<std::string> names;
  std::set<std::string> missed;
  std::set<std::string> not_found;
  Log log;
  if (!filter.device.empty()) {
    if (const auto found = find_device(sender, filter.device, filter.module); !found) {
      log.problems = found.problems();
      return log;
    }
    names.insert(filter.device);
  } else {
    const auto reports = all_reports(sender);
    if (!reports) {
      log.problems = reports.problems();
      log.problems[0].fix += "; to read the fault record of a stopped node, use --file";
      return log;
    }
    log.problems = reports->problems;
    for (const wire::ObservedDevice& seen : sender.observer().devices())
      (seen.alive ? names : missed).insert(seen.name());
    for (const auto& [name, modules] : reports->lost) missed.insert(name);
    not_found = reports->missing();
  }
  std::vector<CommandRequest> requests;
  for (const std::string& name : names) requests.push_back(request_of(name, filter));
  auto answers = sender.send(requests, give_up);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const auto answer = accepted(std::move(answers[i]));
    if (answer)
      add_events_of(log, requests[i].device, *answer, filter.device.empty() ? &missed : nullptr);
    else
      add_new(log.problems, answer.problems());
  }
  for (const std::string& name : missed) {
    if (names.contains(name)) continue;
    log.problems.push_back(
        {"device " + name, "it is lost; its fault record can be read only on its machine",
         std::string{wire::kLostRemedy} + ", or read the file there with takt log --file"});
  }
  for (const std::string& name : not_found) {
    if (names.contains(name) || missed.contains(name)) continue;
    log.problems.push_back({"device " + name,
                            "other devices of its cell list it, but this program did not find it",
                            "try again, or read the file on its machine with takt log --file"});
  }
  sort_by_time(log.events);
  if (filter.last && log.events.size() > *filter.last)
    log.events.erase(log.events.begin(), log.events.end() - static_cast<std::ptrdiff_t>(*filter.last));
  return log;
}

struct LogFollower::Inside {
  struct Position {
    std::uint64_t sequence = 0;
    std::int64_t time_ns = 0;
    /// When the follower received the first event of the device. Empty if the log passed to go_on_after()
    /// contains the device.
    std::optional<Clock::time_point> found{};
  };

  std::mutex mutex;
  std::condition_variable came;
  std::deque<model::Fault> news;
  std::map<std::string, Position> positions;  ///< the last returned event of each device
  std::int64_t began_ns = 0;
  // Must be the last member: it is destroyed first, so that no callback uses members that are already
  // destroyed.
  std::optional<dds::Reader<FaultEvent>> reader;
};

LogFollower::LogFollower(std::unique_ptr<Inside> inside) noexcept : inside_(std::move(inside)) {}
LogFollower::~LogFollower() = default;

Result<std::unique_ptr<LogFollower>> LogFollower::create(std::shared_ptr<dds::Participant> participant) {
  auto inside = std::make_unique<Inside>();
  Inside* const me = inside.get();
  me->began_ns =
      std::chrono::duration_cast<Nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  auto reader = dds::Reader<FaultEvent>::create(std::move(participant),
                                                {.sample = [me](const FaultEvent& event, wire::WriterId) {
                                                  {
                                                    const std::lock_guard lock{me->mutex};
                                                    me->news.push_back(wire::from_wire(event));
                                                  }
                                                  me->came.notify_all();
                                                }});
  if (!reader) return reader.problems();
  inside->reader.emplace(std::move(*reader));
  return std::unique_ptr<LogFollower>{new LogFollower{std::move(inside)}};
}

void LogFollower::go_on_after(const Log& log) {
  for (const DeviceLog& device : log.devices)
    inside_->positions[device.device] = {device.newest, device.newest_time_ns};
}

std::vector<model::Fault> LogFollower::next(Operator& sender, Nanoseconds limit, Problems& problems) {
  std::deque<model::Fault> news;
  {
    std::unique_lock lock{inside_->mutex};
    inside_->came.wait_for(lock, limit, [this] { return !inside_->news.empty(); });
    news.swap(inside_->news);
  }
  std::vector<model::Fault> events;
  const auto add = [&events](Inside::Position& position, model::Fault fault) {
    position.sequence = fault.sequence;
    position.time_ns = std::max(position.time_ns, fault.time_ns);
    events.push_back(std::move(fault));
  };
  for (model::Fault& fault : news) {
    const auto [at, added] = inside_->positions.try_emplace(fault.device);
    Inside::Position& position = at->second;
    const auto now = Clock::now();
    if (added) position.found = now;
    // A node that the follower discovers later first sends its latest events. Of these events, the follower
    // skips those from before its own start. Later than kLastEvents after the first event, it accepts every
    // event, because the node's clock may be behind.
    if (position.found && now - *position.found < kLastEvents && fault.time_ns < inside_->began_ns) {
      position.sequence = fault.sequence;
      position.time_ns = std::max(position.time_ns, fault.time_ns);
      continue;
    }
    if (added) {
      add(position, std::move(fault));
      continue;
    }
    if (fault.sequence <= position.sequence) {
      // The sequence number is not new. So the follower has already returned the event, or the node has lost
      // its fault record and counts from 1 again. In the second case, the event has a later time.
      if (fault.time_ns > position.time_ns) add(position, std::move(fault));
      continue;
    }
    if (fault.sequence > position.sequence + 1 && position.sequence != 0) {
      model::FaultFilter missing{.after = position.sequence};
      const auto answer = accepted(sender.send(request_of(fault.device, missing)));
      Log log;
      if (answer) add_events_of(log, fault.device, *answer, nullptr);
      for (model::Fault& each : log.events) {
        if (each.sequence > position.sequence && each.sequence < fault.sequence)
          add(position, std::move(each));
      }
      if (fault.sequence > position.sequence + 1) {
        problems.push_back({"device " + fault.device,
                            std::to_string(fault.sequence - position.sequence - 1) + " events before event " +
                                std::to_string(fault.sequence) + " are missing",
                            ""});
      }
    }
    add(position, std::move(fault));
  }
  return events;
}

}  // namespace takt::client
