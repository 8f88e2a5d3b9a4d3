#include "web/watched_ports.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include <takt/client/tap.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/model/json.hpp>
#include <takt/os/clock.hpp>

#include "web/samples_json.hpp"
#include "web/value_history.hpp"

namespace takt::tool::web {

namespace {

// How many values of a port, and of all its ports, a stream gets at once. 8000 values are about 4.8 MB if
// each has 32 fields; the limit of a stream's queue is 8 MiB.
constexpr std::size_t kMostOfPort = 1000;
constexpr std::size_t kMostAtOnce = 8000;

}  // namespace

struct WatchedPorts::Source {
  explicit Source(dds::Flow of) : flow(std::move(of)), columns(flow.type) {
    for (std::size_t i = 0; i < columns.all().size() && shown.size() < kMostFields; ++i) {
      if (columns.all()[i].drawable) shown.push_back(i);
    }
    row.resize(shown.size());
  }

  /// Adds a sample of the port. DDS calls this on its own thread.
  void add(const std::byte* bytes, std::size_t size, std::int64_t time_ns) {
    const std::lock_guard lock{mutex};
    newest.assign(bytes, bytes + size);
    if (!whole && std::abs(time_ns - history.newest()) < Nanoseconds{kNewestEvery}.count() / 2) return;
    columns.values(bytes, size, values);
    for (std::size_t i = 0; i < shown.size(); ++i)
      row[i] = values[shown[i]].number(!columns.all()[shown[i]].enumerators.empty());
    history.add(time_ns, row);
    if (!whole) history.forget(time_ns - Nanoseconds{kKept}.count());
  }

  [[nodiscard]] bool is_of(const dds::Flow& other) const {
    return flow.topic == other.topic && flow.type == other.type &&
           flow.quality.reliable == other.quality.reliable;
  }

  /// Keeps all values for hours, or only some of the last minutes.
  void keep_all(bool all) {
    const std::lock_guard lock{mutex};
    if (!whole && all) plotted = os::now();
    whole = all;
  }

  /// The newest value in a short form; empty if none has arrived.
  std::string newest_text() {
    const std::lock_guard lock{mutex};
    if (newest.empty()) return "";
    columns.values(newest.data(), newest.size(), values);
    return short_text(columns, values);
  }

  [[nodiscard]] Json description(const std::string& port) const {
    Json fields = Json::array();
    for (const std::size_t i : shown) {
      const recording::Column& column = columns.all()[i];
      Json field{{"name", column.name}};
      if (!column.unit.empty()) field["unit"] = column.unit;
      if (!column.enumerators.empty()) field["labels"] = column.enumerators;
      fields.push_back(std::move(field));
    }
    return {{"port", port}, {"type", flow.type.name}, {"fields", std::move(fields)}};
  }

  /// Returns the next values, at most `most`, for a stream that already has the values until `has`, in ns,
  /// and sets `has` to the time of the last one. Returns none if there are no new values.
  std::optional<Json> news(const std::string& port, std::int64_t& has, std::size_t most) {
    const std::lock_guard lock{mutex};
    history.complete();
    const bool from_begin = has == 0 || has > history.newest();  // the latter if the history has begun anew
    const auto rows = history.after(from_begin ? 0 : has, most);
    if (rows.empty()) return std::nullopt;
    Json times = Json::array();
    std::vector<Json> series(shown.size(), Json::array());
    for (const ValueHistory::Row* next : rows) {
      times.push_back(static_cast<double>(next->time_ns) / 1e6);
      for (std::size_t i = 0; i < shown.size(); ++i) {
        const double value = next->values[i];
        series[i].push_back(std::isnan(value) ? Json() : Json(value));
      }
    }
    has = rows.back()->time_ns;
    return Json{
        {"port", port}, {"whole", from_begin}, {"times_ms", std::move(times)}, {"values", std::move(series)}};
  }

  const dds::Flow flow;
  const recording::Columns columns;
  std::vector<std::size_t> shown;
  Instant asked{};
  Instant used{};
  Instant plotted{};
  bool whole = false;  // true if all values are kept; changed only while both WatchedPorts::mutex_ and
                       // `mutex` are locked, or before the source is known

  std::mutex mutex;
  std::vector<std::byte> newest;  // the last sample
  ValueHistory history;
  std::vector<recording::Value> values;  // of the last sample, kept to allocate no memory
  std::vector<double> row;

  std::unique_ptr<dds::Tap> tap;  // the last member, so it is destroyed first and adds no more values
};

WatchedPorts::WatchedPorts(client::Connection& client, Streams& streams)
    : client_(client), streams_(streams) {}
WatchedPorts::~WatchedPorts() = default;

/// Makes the source of a port, unless it is known. A source whose flow has changed is made anew, and the
/// streams that plot the port get the new description, and then all values.
Result<void> WatchedPorts::keep(const std::string& port, dds::Flow flow, bool whole) {
  const auto is_known = [&](const dds::Flow& now) {
    const auto found = sources_.find(port);
    if (found == sources_.end() || !found->second->is_of(now)) return false;
    found->second->asked = os::now();
    found->second->keep_all(found->second->whole || whole);
    return true;
  };
  {
    const std::lock_guard lock{mutex_};
    if (is_known(flow)) return {};
  }
  auto made = std::make_shared<Source>(std::move(flow));
  made->asked = made->used = os::now();
  made->keep_all(whole);
  auto tap =
      dds::Tap::create(client_.participant, made->flow,
                       [source = made.get()](const std::byte* bytes, std::size_t size, std::int64_t time_ns) {
                         source->add(bytes, size, time_ns);
                       });
  if (!tap) return tap.problems();
  made->tap = std::move(*tap);
  const std::string text = event_text("port", model::json_text(made->description(port)));
  const std::lock_guard lock{mutex_};
  if (is_known(made->flow)) return {};  // another thread has made it meanwhile
  made.swap(sources_[port]);            // the former source is destroyed after the lock is released
  for (auto& [id, view] : views_) {
    const auto shown = view.plotted.find(port);
    const auto stream = streams_.find(id);
    if (shown == view.plotted.end() || !stream) continue;
    shown->second = 0;
    stream->send(text);
  }
  return {};
}

/// Asks the devices to publish these ports; true: every sample. Returns the problems of each port that
/// failed.
std::map<std::string, Problems> WatchedPorts::ask(const std::map<std::string, bool>& ports) {
  std::map<std::string, Problems> failed;
  std::vector<client::CommandRequest> requests;
  std::vector<std::string> asked;
  for (const auto& [port, whole] : ports) {
    auto request = client::tap_request(port, whole ? Nanoseconds{0} : kNewestEvery);
    if (!request) {
      failed[port] = request.problems();
      continue;
    }
    requests.push_back(std::move(*request));
    asked.push_back(port);
  }
  auto answers = client_.sender->send(requests);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const std::string& port = asked[i];
    const auto answer = client::accepted(std::move(answers[i]));
    auto flow = answer ? client::flow_in(answer->data, port) : answer.problems();
    const auto kept = flow ? keep(port, std::move(*flow), ports.at(port)) : flow.problems();
    if (!kept) failed[port] = kept.problems();
  }
  return failed;
}

Problems WatchedPorts::want(const std::shared_ptr<Stream>& stream, const Ports& plotted, const Ports& newest,
                            const Ports& again) {
  std::map<std::string, bool> missing;
  {
    const std::lock_guard lock{mutex_};
    for (const std::string& port : newest.value_or(std::vector<std::string>{})) {
      if (!sources_.contains(port)) missing[port] = false;
    }
    for (const std::string& port : plotted.value_or(std::vector<std::string>{})) {
      const auto found = sources_.find(port);
      if (found == sources_.end() || !found->second->whole) missing[port] = true;
    }
  }
  auto failed = ask(missing);
  Problems problems;
  const std::lock_guard lock{mutex_};
  View& view = views_[stream->id()];
  const auto source_of = [&](const std::string& port, bool to_plot) -> const Source* {
    const auto found = sources_.find(port);
    if (found != sources_.end() && to_plot && found->second->shown.empty() && !failed.contains(port))
      failed[port] = {
          fail(port + " has no numeric field", "use takt echo " + port + " to print its samples")};
    if (found != sources_.end() && !failed.contains(port)) return found->second.get();
    for (Problem problem : failed[port]) {
      problem.where = port;
      problems.push_back(std::move(problem));
    }
    return nullptr;
  };
  if (plotted) {
    auto before = std::exchange(view.plotted, {});
    for (const std::string& port : again.value_or(std::vector<std::string>{})) before.erase(port);
    for (const std::string& port : *plotted) {
      const Source* const source = source_of(port, true);
      if (source == nullptr) continue;
      const auto [has, is_new] = view.plotted.insert({port, 0});
      if (const auto known = before.find(port); known != before.end()) {
        has->second = known->second;
      } else if (is_new) {
        stream->send(event_text("port", model::json_text(source->description(port))));
      }
    }
  }
  if (newest) {
    std::map<std::string, std::string> shown;
    for (const std::string& port : *newest) {
      if (source_of(port, false) != nullptr) shown[port] = view.newest[port];
    }
    view.newest = std::move(shown);
  }
  return problems;
}

void WatchedPorts::send() {
  const std::lock_guard lock{mutex_};
  const Instant now = os::now();
  const bool send_newest_now = now - newest_sent_ >= kNewestEvery;
  if (send_newest_now) newest_sent_ = now;
  for (auto one = views_.begin(); one != views_.end();) {
    const auto stream = streams_.find(one->first);
    if (!stream || stream->ended()) {
      one = views_.erase(one);
      continue;
    }
    View& view = one->second;
    const std::size_t most =
        std::min(kMostOfPort, kMostAtOnce / std::max<std::size_t>(view.plotted.size(), 1));
    for (auto& [port, has] : view.plotted) {
      const auto source = sources_.find(port);
      if (source == sources_.end()) continue;
      source->second->used = source->second->plotted = now;
      if (const auto news = source->second->news(port, has, most))
        stream->send(event_text("points", model::json_text(*news)));
    }
    if (send_newest_now) send_newest(*stream, view);
    ++one;
  }
}

void WatchedPorts::send_newest(Stream& stream, View& view) {
  Json values = Json::object();
  for (auto& [port, has] : view.newest) {
    const auto source = sources_.find(port);
    if (source == sources_.end()) continue;
    source->second->used = newest_sent_;
    std::string text = source->second->newest_text();
    if (text == has) continue;
    values[port] = text;
    has = std::move(text);
  }
  if (!values.empty()) stream.send(event_text("newest", model::json_text({{"values", std::move(values)}})));
}

void WatchedPorts::maintain() {
  std::map<std::string, bool> again;
  std::vector<std::shared_ptr<Source>>
      gone;  // destroyed after the lock is released, because ~Source waits for a DDS thread
  const auto lives = [this](const std::string& port) {
    const auto devices = client_.observer->devices(port.substr(0, port.find('.')));
    return std::any_of(devices.begin(), devices.end(), [](const wire::ObservedDevice& d) { return d.alive; });
  };
  {
    const std::lock_guard lock{mutex_};
    const Instant now = os::now();
    for (auto one = sources_.begin(); one != sources_.end();) {
      Source& source = *one->second;
      if (now - source.used > kKept) {
        gone.push_back(std::move(one->second));
        one = sources_.erase(one);
        continue;
      }
      if (source.whole && now - source.plotted > kUnplotted) source.keep_all(false);
      if (now - source.asked > client::kAskAgain) {
        source.asked = now;
        again[one->first] = source.whole;
      }
      ++one;
    }
  }
  std::erase_if(again, [&lives](const auto& port) { return !lives(port.first); });
  if (!again.empty()) ask(again);  // a device that fails is lost or still starting; the page shows its state
}

}  // namespace takt::tool::web
