#include <takt/client/log.hpp>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/wire/fault.hpp>
#include <takt/dds/topics.hpp>
#include <takt/model/json.hpp>
#include "reports.hpp"

namespace takt::client {

namespace {

using Clock = std::chrono::steady_clock;
using json = nlohmann::ordered_json;

/// Within this time after its discovery, a node sends its latest events again.
constexpr std::chrono::seconds kLastEvents{3};

Question question_of(const std::string& device, const model::FaultFilter& filter) {
  return {.kind = COMMAND_LOG, .device = device, .data = model::json_text(model::to_json(filter))};
}

Problem unreadable(const std::string& device) {
  return {"device " + device, "its answer is not a fault record",
          "check that it runs the same version of Takt as this program"};
}

// Adds each problem only once. If two nodes have the same device name, every question to this device fails
// with the same problem.
void add_new(Problems& problems, const Problems& more) {
  for (const Problem& problem : more) {
    if (std::find(problems.begin(), problems.end(), problem) == problems.end()) problems.push_back(problem);
  }
}

// Adds the events in a node's answer to `log`, and the devices that the node has lost to `missed`.
void add_events_of(Log& log, const std::string& device, const wire::WholeReply& reply,
                   std::set<std::string>* missed) {
  const json value = model::parse_json(reply.data);
  try {
    DeviceLog own{.device = device,
                  .file = value.at("file").is_null() ? "" : value.at("file").get<std::string>(),
                  .newest = value.at("newest"),
                  .newest_time_ns = value.at("newest_time_ns"),
                  .overwritten = value.at("overwritten"),
                  .damaged = value.at("damaged")};
    for (const json& event : value.at("events")) {
      auto fault = model::fault_from(event);
      if (!fault) throw std::invalid_argument{"no event"};
      log.events.push_back(std::move(*fault));
    }
    for (const json& name : value.at("lost")) {
      if (missed != nullptr) missed->insert(name.get<std::string>());
    }
    log.devices.push_back(std::move(own));
  } catch (const std::exception&) {
    log.problems.push_back(unreadable(device));
  }
}

}  // namespace

void sort_by_time(std::vector<model::Fault>& events) {
  // A node's rate limit may merge events. A merged event may have an earlier time than the event before it.
  // So events of one device stay in the order of their sequence numbers.
  std::stable_sort(events.begin(), events.end(),
                   [](const auto& a, const auto& b) { return a.sequence < b.sequence; });
  std::map<std::string, std::int64_t> newest;
  std::vector<std::pair<std::int64_t, model::Fault>> placed;
  for (model::Fault& event : events) {
    std::int64_t& time = newest[event.device];
    time = std::max(time, event.time_ns);
    placed.emplace_back(time, std::move(event));
  }
  std::stable_sort(placed.begin(), placed.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  events.clear();
  for (auto& [time, event] : placed) events.push_back(std::move(event));
}

Log read_log(Operator& asker, const model::FaultFilter& filter, Nanoseconds limit) {
  std::set<std::string> names;
  std::set<std::string> missed;
  std::set<std::string> not_found;
  Log log;
  if (!filter.device.empty()) {
    names.insert(filter.device);
  } else {
    const auto reports = all_reports(asker, limit);
    if (!reports) {
      log.problems = reports.problems();
      log.problems[0].fix += "; to read the fault record of a stopped node, use --file";
      return log;
    }
    log.problems = reports->problems;
    for (const wire::ObservedDevice& seen : asker.observer().devices())
      (seen.alive ? names : missed).insert(seen.name());
    for (const auto& [name, modules] : reports->lost) missed.insert(name);
    not_found = reports->missing();
  }
  std::vector<Question> questions;
  for (const std::string& name : names) questions.push_back(question_of(name, filter));
  auto answers = asker.ask(questions);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const auto answer = accepted(std::move(answers[i]));
    if (answer)
      add_events_of(log, questions[i].device, *answer, filter.device.empty() ? &missed : nullptr);
    else
      add_new(log.problems, answer.problems());
  }
  for (const std::string& name : missed) {
    if (names.contains(name)) continue;
    log.problems.push_back({"device " + name, "it is lost; its fault record can be read only on its machine",
                            "start its node again, or read the file there with takt log --file"});
  }
  for (const std::string& name : not_found) {
    if (names.contains(name) || missed.contains(name)) continue;
    log.problems.push_back(
        {"device " + name,
         "other devices of its cell list it, but this program did not find it within " + takt::to_text(limit),
         "try again, or read the file on its machine with takt log --file"});
  }
  sort_by_time(log.events);
  if (filter.last && log.events.size() > *filter.last)
    log.events.erase(log.events.begin(), log.events.end() - static_cast<std::ptrdiff_t>(*filter.last));
  return log;
}

struct LogFollower::Inside {
  struct Place {
    std::uint64_t sequence = 0;
    std::int64_t time_ns = 0;
    /// When the follower discovered the device's node; empty if the log of go_on_after() already contains the
    /// device.
    std::optional<Clock::time_point> found{};
  };

  std::mutex mutex;
  std::condition_variable came;
  std::deque<model::Fault> news;
  std::map<std::string, Place> places;  ///< the last returned event of each device
  std::int64_t began_ns = 0;
  // Must be the last member: it is destroyed first, so that no callback uses members that are already
  // destroyed.
  std::optional<dds::Reader<FaultEvent>> reader;
};

LogFollower::LogFollower(std::unique_ptr<Inside> inside) noexcept : inside_(std::move(inside)) {}
LogFollower::~LogFollower() = default;

Result<std::unique_ptr<LogFollower>> LogFollower::create(std::shared_ptr<dds::Participant> participant) {
  auto inside = std::make_unique<Inside>();
  Inside* const place = inside.get();
  place->began_ns =
      std::chrono::duration_cast<Nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  auto reader = dds::Reader<FaultEvent>::create(std::move(participant),
                                                {.sample = [place](const FaultEvent& event, wire::WriterId) {
                                                  {
                                                    const std::lock_guard lock{place->mutex};
                                                    place->news.push_back(wire::from_wire(event));
                                                  }
                                                  place->came.notify_all();
                                                }});
  if (!reader) return reader.problems();
  inside->reader.emplace(std::move(*reader));
  return std::unique_ptr<LogFollower>{new LogFollower{std::move(inside)}};
}

void LogFollower::go_on_after(const Log& log) {
  for (const DeviceLog& device : log.devices)
    inside_->places[device.device] = {device.newest, device.newest_time_ns};
}

std::vector<model::Fault> LogFollower::next(Operator& asker, Nanoseconds limit, Problems& problems) {
  std::deque<model::Fault> news;
  {
    std::unique_lock lock{inside_->mutex};
    inside_->came.wait_for(lock, limit, [this] { return !inside_->news.empty(); });
    news.swap(inside_->news);
  }
  std::vector<model::Fault> events;
  const auto add = [&events](Inside::Place& place, model::Fault fault) {
    place.sequence = fault.sequence;
    place.time_ns = std::max(place.time_ns, fault.time_ns);
    events.push_back(std::move(fault));
  };
  for (model::Fault& fault : news) {
    const auto [at, added] = inside_->places.try_emplace(fault.device);
    Inside::Place& place = at->second;
    const auto now = Clock::now();
    if (added) place.found = now;
    // A node that is discovered later sends its latest events at once. Of these, the follower skips events
    // from before its own start. After kLastEvents it accepts every event, because the node's clock may be
    // slow.
    if (place.found && now - *place.found < kLastEvents && fault.time_ns < inside_->began_ns) {
      place.sequence = fault.sequence;
      place.time_ns = std::max(place.time_ns, fault.time_ns);
      continue;
    }
    if (added) {
      add(place, std::move(fault));
      continue;
    }
    if (fault.sequence <= place.sequence) {
      // A sequence number that is not new: the follower has already returned the event, or the node has lost
      // its fault record and counts from 1 again. In the second case the time is later.
      if (fault.time_ns > place.time_ns) add(place, std::move(fault));
      continue;
    }
    if (fault.sequence > place.sequence + 1 && place.sequence != 0) {
      model::FaultFilter missing{.after = place.sequence};
      const auto answer = accepted(asker.ask(question_of(fault.device, missing)));
      Log log;
      if (answer) add_events_of(log, fault.device, *answer, nullptr);
      for (model::Fault& each : log.events) {
        if (each.sequence > place.sequence && each.sequence < fault.sequence) add(place, std::move(each));
      }
      if (fault.sequence > place.sequence + 1) {
        problems.push_back({"device " + fault.device,
                            std::to_string(fault.sequence - place.sequence - 1) + " events before event " +
                                std::to_string(fault.sequence) + " are missing",
                            ""});
      }
    }
    add(place, std::move(fault));
  }
  return events;
}

}  // namespace takt::client
