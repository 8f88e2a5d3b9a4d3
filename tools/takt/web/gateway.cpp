#include "web/gateway.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <set>
#include <sstream>
#include <utility>

#include <takt/core/words.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/model/json.hpp>
#include <takt/os/clock.hpp>
#include <takt/wire/words.hpp>

namespace takt::tool::web {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::size_t kMostProblems = 20;  // number of kept problems in reading fault records
constexpr std::size_t kTrend = 120;        // length of the jitter series sent to a new page, in seconds
constexpr milliseconds kTogether{20};      // state changes within this time are sent in one event
constexpr milliseconds kTurn{100};
constexpr seconds kMeasures{1};
constexpr seconds kNodeAnswered{3};
constexpr seconds kAskAgain{10};  // time between two requests for the descriptor

std::string state_event(bool whole, Json devices, Json modules) {
  return event_text(
      "state",
      model::json_text({{"whole", whole}, {"devices", std::move(devices)}, {"modules", std::move(modules)}}));
}

/// The list of ports in a member of a request. The inner value is empty if the request does not have this
/// member; the outer one, if the list is not valid.
std::optional<WatchedPorts::Ports> list_in(const Json& asked, const char* name, std::size_t most) {
  if (!asked.is_object()) return std::nullopt;
  if (!asked.contains(name)) return WatchedPorts::Ports{};
  const Json& list = asked[name];
  if (!list.is_array() || list.size() > most) return std::nullopt;
  std::vector<std::string> ports;
  for (const Json& port : list) {
    if (!port.is_string()) return std::nullopt;
    ports.push_back(port.get<std::string>());
  }
  return WatchedPorts::Ports{std::move(ports)};
}

Json values_of(const std::map<std::string, Json>& all) {
  Json list = Json::array();
  for (const auto& [name, value] : all) list.push_back(value);
  return list;
}

}  // namespace

/// The queue of state transitions from the DDS threads to the sender thread.
struct Gateway::News {
  void add(const LifecycleStatus& status) {
    {
      const std::lock_guard lock{mutex};
      if (steps.size() < kMost) steps.push_back(status);
      there = true;
    }
    arrived.notify_one();
  }
  void wake() {
    {
      const std::lock_guard lock{mutex};
      there = true;
    }
    arrived.notify_one();
  }
  /// Waits for transitions or wake(), at most `limit`, and returns the transitions that have arrived.
  std::vector<LifecycleStatus> wait(milliseconds limit) {
    std::unique_lock lock{mutex};
    arrived.wait_for(lock, limit, [this] { return there; });
    there = false;
    return std::exchange(steps, {});
  }

  static constexpr std::size_t kMost = 100'000;
  std::mutex mutex;
  std::condition_variable arrived;
  std::vector<LifecycleStatus> steps;
  bool there = false;
};

Gateway::Gateway(std::unique_ptr<News> news) noexcept : news_(std::move(news)) {}

Result<std::unique_ptr<Gateway>> Gateway::create(const client::Network& network) {
  auto news = std::make_unique<News>();
  News* const to = news.get();
  std::unique_ptr<Gateway> gateway{new Gateway{std::move(news)}};
  auto client = client::connect(network, nullptr,
                                {.news = {.module = [to](const LifecycleStatus& status) { to->add(status); },
                                          .device = [to](const wire::ObservedDevice&) { to->wake(); }},
                                 .statistics = true});
  if (!client) return client.problems();
  gateway->client_ = std::move(*client);
  auto follower = client::LogFollower::create(gateway->client_.participant);
  if (!follower) return follower.problems();
  gateway->follower_ = std::move(*follower);
  gateway->device_requests_ = std::make_unique<DeviceRequests>(*gateway->client_.sender);
  gateway->watched_ = std::make_unique<WatchedPorts>(gateway->client_, gateway->streams_);
  gateway->cell_text_ = event_text("cell", model::json_text(cell_json(nullptr, gateway->client_.domain, "")));
  gateway->sender_ = std::thread{[self = gateway.get()] { self->run_sender(); }};
  gateway->fetcher_ = std::thread{[self = gateway.get()] { self->run_fetcher(); }};
  return gateway;
}

Gateway::~Gateway() {
  ended_ = true;
  news_->wake();
  if (sender_.joinable()) sender_.join();
  if (fetcher_.joinable()) fetcher_.join();
}

std::shared_ptr<const model::Cell> Gateway::cell() const {
  const std::lock_guard lock{mutex_};
  return cell_;
}

// Sends the complete state to a new page. All changes are sent under the same lock, so the page misses none
// of them.
std::shared_ptr<Stream> Gateway::open(const std::string& address) {
  const std::lock_guard lock{mutex_};
  auto stream = streams_.open(address);
  if (!stream) return nullptr;
  stream->send(event_text("stream", model::json_text({{"id", stream->id()}})));
  stream->send(cell_text_);
  stream->send(state_event(true, values_of(devices_), values_of(modules_)));
  if (!measures_.empty()) stream->send(measures_);
  Json trends = Json::object();
  for (const auto& [name, module] : modules_) trends[name] = history_.of(name, kTrend).jitter_us;
  stream->send(event_text("trends", model::json_text({{"jitter_us", std::move(trends)}})));
  stream->send(newest_faults());
  stream->send(all_alarms());
  return stream;
}

// ---- Sending to the pages

void Gateway::run_sender() {
  Instant measured{};
  Instant sent{};
  while (!ended_) {
    auto steps = news_->wait(kTurn);
    if (ended_) return;
    if (!steps.empty()) {
      os::sleep_until(os::now() + kTogether);
      auto more = news_->wait(milliseconds{0});
      steps.insert(steps.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
    }
    send_states(std::move(steps));
    const Instant now = os::now();
    if (now - sent >= kTurn) {
      watched_->send();
      sent = now;
    }
    if (now - measured >= kMeasures) {
      send_measures();
      measured = now;
    }
  }
}

void Gateway::send_states(std::vector<LifecycleStatus> steps) {
  const std::vector<wire::ObservedDevice> seen = client_.observer->devices();
  Json devices = Json::array();
  Json modules = Json::array();
  const std::lock_guard lock{mutex_};
  // First send each transition, in order. Then send each module whose current state is newer than its last
  // transition.
  for (const LifecycleStatus& step : steps) {
    Json json = module_json(step);
    Json& known = modules_[json["name"].get<std::string>()];
    if (known == json) continue;
    known = json;
    modules.push_back(std::move(json));
  }
  std::set<std::string> there;
  for (const wire::ObservedDevice& device : seen) {
    there.insert(device.name());
    if (Json json = device_json(device); devices_[device.name()] != json) {
      devices_[device.name()] = json;
      devices.push_back(std::move(json));
    }
    for (const auto& [name, status] : device.deployment.modules) {
      const std::string path = device.name() + "." + name;
      there.insert(path);
      Json& known = modules_[path];
      if (known.is_null() || known["sequence"] < status.sequence_number()) {
        known = module_json(status);
        modules.push_back(known);
      }
    }
  }
  const auto forget = [&there](std::map<std::string, Json>& all, Json& list) {
    for (auto one = all.begin(); one != all.end();) {
      if (there.count(one->first) != 0) {
        ++one;
        continue;
      }
      list.push_back({{"name", one->first}, {"gone", true}});
      one = all.erase(one);
    }
  };
  forget(devices_, devices);
  forget(modules_, modules);
  if (devices.empty() && modules.empty()) return;
  streams_.send(state_event(false, std::move(devices), std::move(modules)));
}

void Gateway::send_measures() {
  const std::vector<wire::ObservedDevice> seen = client_.observer->devices();
  const auto running = cell();
  Json measures = measures_json(seen, running.get(), os::wall_ns());
  std::set<std::string> lost;  // lost devices, whose last measurements are out of date
  for (const wire::ObservedDevice& device : seen) {
    if (!device.alive) lost.insert(device.name());
  }
  const std::lock_guard lock{mutex_};
  history_.add(seen);
  for (auto& [name, module] : measures["modules"].items()) {
    const client::Series last = history_.of(name, 1);
    if (last.times_ms.empty() || lost.contains(name.substr(0, name.find('.')))) continue;
    module["recent_us"] = {{"jitter", last.jitter_us.back()}, {"run", last.run_us.back()}};
  }
  std::string text = event_text("measures", model::json_text(measures));
  streams_.send(text);
  measures_ = std::move(text);
}

// Returns the event `faults` with the newest events. The caller must hold the lock.
std::string Gateway::newest_faults() const {
  return event_text("faults", "{\"whole\":true," + faults_.newest() +
                                  ",\"problems\":" + model::json_text(Json(problems_)) + "}");
}

// Keeps problems that occurred while fault records were read, for the pages. The caller must hold the lock.
void Gateway::keep_problems(const Problems& problems) {
  for (const Problem& problem : problems) {
    problems_.push_back(in_words({problem}));
    if (problems_.size() > kMostProblems) problems_.pop_front();
  }
}

void Gateway::add_faults(const std::vector<model::Fault>& faults, const Problems& problems) {
  if (faults.empty() && problems.empty()) return;
  std::string events;
  const std::lock_guard lock{mutex_};
  for (const model::Fault& fault : faults) {
    ++counted_.faults[fault.device].at(static_cast<std::size_t>(model::severity_of(fault.kind)));
    events += (events.empty() ? "" : ",") + faults_.add(fault);
  }
  keep_problems(problems);
  streams_.send(event_text("faults", "{\"whole\":false,\"events\":[" + events +
                                         "],\"problems\":" + model::json_text(Json(problems_)) + "}"));
}

// Adds events from a fault record. These events happened before the gateway found the device. So they are
// inserted by their time, and do not count as new.
void Gateway::add_record(const client::Log& read) {
  if (read.events.empty() && read.problems.empty()) return;
  const std::lock_guard lock{mutex_};
  const auto has_lost = [](const client::DeviceLog& device) { return device.overwritten > 0; };
  faults_.add_record(read.events, std::ranges::none_of(read.devices, has_lost));
  keep_problems(read.problems);
  streams_.send(newest_faults());
}

// ---- Asking the devices

void Gateway::run_fetcher() {
  client_.observer->settle(seconds{1});
  while (!ended_) {
    look_for_cell();
    read_records();
    read_alarms();
    follow_faults();
    watched_->maintain();
  }
}

// Reads the fault record of each device once, to get the events that happened before this program found the
// device.
void Gateway::read_records() {
  for (const wire::ObservedDevice& seen : client_.observer->devices()) {
    if (!seen.alive || ended_ || !recorded_.insert(seen.name()).second) continue;
    const client::Log read = client::read_log(*client_.sender, {.device = seen.name()});
    add_record(read);
    follower_->go_on_after(read);
  }
}

// Asks each device for its alarms when its status says that they have changed. A lost device keeps its last
// alarms.
void Gateway::read_alarms() {
  auto next = alarms_;
  std::set<std::string> found;
  for (const wire::ObservedDevice& seen : client_.observer->devices()) {
    found.insert(seen.name());
    const std::uint64_t changes = seen.status.alarm_changes();
    OfDevice& known = next[seen.name()];
    if (!seen.alive || ended_ || (known.node == seen.node() && known.changes == changes)) continue;
    if (changes == 0) {
      known = {.node = seen.node()};
      continue;
    }
    const auto reply = client::accepted(
        client_.sender->send({.kind = COMMAND_ALARMS, .device = seen.name(), .limit = kNodeAnswered}));
    if (!reply) continue;  // run_fetcher() tries again in its next cycle
    if (auto alarms = client::alarms_in(seen.name(), reply->data); alarms)
      known = {.node = seen.node(), .changes = changes, .alarms = std::move(*alarms)};
  }
  std::erase_if(next, [&found](const auto& each) { return !found.contains(each.first); });
  if (next == alarms_) return;
  const std::lock_guard lock{mutex_};
  alarms_ = std::move(next);
  streams_.send(all_alarms());
}

// Returns the event `alarms` with the alarms of all devices, the worst first. The caller must hold the lock.
std::string Gateway::all_alarms() const {
  std::vector<model::Alarm> all;
  for (const auto& [device, known] : alarms_) all.insert(all.end(), known.alarms.begin(), known.alarms.end());
  std::ranges::stable_sort(all, model::is_worse);
  Json alarms = Json::array();
  for (const model::Alarm& alarm : all) alarms.push_back(alarm_json(alarm));
  return event_text("alarms", model::json_text({{"alarms", std::move(alarms)}}));
}

void Gateway::follow_faults() {
  Problems problems;
  auto events = follower_->next(*client_.sender, kTurn, problems);
  client::sort_by_time(events);
  add_faults(events, problems);
}

// True if the shown cell is lost: no device of the cell is alive. The page keeps showing a lost cell. If a
// live device no longer has the cell, the cell was removed and the page stops showing it.
bool Gateway::is_lost() const {
  if (!cell_) return false;
  bool lost = false;
  for (const model::Device& device : cell_->devices) {
    for (const wire::ObservedDevice& seen : client_.observer->devices(device.name)) {
      if (seen.alive) return false;
      lost = true;
    }
  }
  return lost;
}

// Finds the cell that runs on the live devices. If the domain has devices of two cells, the page shows all
// devices, but the graph and the tables of only one cell.
void Gateway::look_for_cell() {
  std::string deployment;  // an update changes the descriptor but keeps this name
  std::string device;
  for (const wire::ObservedDevice& seen : client_.observer->devices()) {
    const std::string id = seen.status.deployment().to_string();
    if (!seen.alive || id.empty()) continue;
    if (deployment.empty() || id == deployment_) {
      deployment = id;
      device = seen.name();
    }
  }
  const Instant now = os::now();
  if (deployment == deployment_ && (deployment.empty() || now - asked_ < kAskAgain)) return;
  if (deployment.empty() && is_lost()) return;
  std::shared_ptr<const model::Cell> cell;
  std::string descriptor;
  if (!deployment.empty()) {
    const auto reply = client::accepted(
        client_.sender->send({.kind = COMMAND_DESCRIPTOR, .device = device, .limit = kNodeAnswered}));
    if (!reply) return;  // run_fetcher() tries again in its next cycle
    asked_ = now;
    if (deployment == deployment_ && reply->data == descriptor_) return;
    descriptor = reply->data;
    auto read = descriptor::parse(descriptor, reply->head.value().to_string());
    if (read) {
      read->domain = client_.domain;  // the descriptor may give another domain than --domain
      cell = std::make_shared<const model::Cell>(std::move(*read));
    }
  }
  std::string text = event_text("cell", model::json_text(cell_json(cell.get(), client_.domain, deployment)));
  const std::lock_guard lock{mutex_};
  deployment_ = deployment;
  descriptor_ = std::move(descriptor);
  cell_ = std::move(cell);
  cell_text_ = std::move(text);
  streams_.send(cell_text_);
}

// ---- Answering requests of the pages

Answer Gateway::watch(const std::string& id, const std::string& body) {
  const auto stream = streams_.find(id);
  if (!stream) return answer_of(404, fail("there is no such event stream", "open /api/events again"));
  const Json asked = model::parse_json(body);
  const auto plotted = list_in(asked, "ports", WatchedPorts::kMost);
  const auto newest = list_in(asked, "newest", WatchedPorts::kMostNewest);
  const auto again = list_in(asked, "again", WatchedPorts::kMost);
  if (!plotted || !newest || !again || (!*plotted && !*newest)) {
    return answer_of(
        400, fail("not a valid list of ports: " + in_quotes(body.substr(0, 100)),
                  R"(send {"ports": ["device.module.port"]}, with at most )" +
                      std::to_string(WatchedPorts::kMost) + R"(, or {"newest": [...]}, with at most )" +
                      std::to_string(WatchedPorts::kMostNewest)));
  }
  Json problems = Json::array();
  for (const Problem& problem : watched_->want(stream, *plotted, *newest, *again))
    problems.push_back({{"port", problem.where}, {"what", problem.what}, {"fix", problem.fix}});
  return answer_of(Json{{"problems", std::move(problems)}});
}

Answer Gateway::graph(const std::string& collapsed) const {
  const auto running = cell();
  if (!running) return answer_of(409, fail("no cell is running", "deploy a cell"));
  GraphPage page;
  std::istringstream names{collapsed};
  for (std::string name; std::getline(names, name, ',');) page.collapsed.insert(name);
  return answer_of(Json{{"graph", graph_of(*running, page)}});
}

Answer Gateway::faults(const std::string& before) const {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(before.data(), before.data() + before.size(), number);
  if (error != std::errc{} || end != before.data() + before.size())
    return answer_of(400, fail("not the number of an event: " + in_quotes(before.substr(0, 100)),
                               "send the number in the member older"));
  const std::lock_guard lock{mutex_};
  return {.body = "{" + faults_.before(number) + "}"};
}

Answer Gateway::history(const std::string& module) {
  client::Series series;
  {
    const std::lock_guard lock{mutex_};
    series = history_.of(module);
  }
  return answer_of(Json{{"times_ms", series.times_ms},
                        {"jitter_p50_us", series.jitter_p50_us},
                        {"jitter_p99_us", series.jitter_p99_us},
                        {"run_p50_us", series.run_p50_us},
                        {"run_p99_us", series.run_p99_us},
                        {"jitter_us", series.jitter_us},
                        {"run_us", series.run_us}});
}

std::string Gateway::metrics() {
  const auto running = cell();
  Counted counted;
  {
    const std::lock_guard lock{mutex_};
    counted = counted_;
  }
  counted.viewers = streams_.count();
  const auto devices = client_.observer->devices();
  // Prometheus detects an increase only in a series that exists, so report 0 for a device without events.
  for (const wire::ObservedDevice& device : devices) counted.faults.try_emplace(device.name());
  return metrics_text(devices, running.get(), counted);
}

}  // namespace takt::tool::web
