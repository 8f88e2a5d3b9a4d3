#include "web/watched_ports.hpp"

#include <algorithm>
#include <cmath>
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
    columns.values(bytes, size, values);
    for (std::size_t i = 0; i < shown.size(); ++i)
      row[i] = values[shown[i]].number(!columns.all()[shown[i]].enumerators.empty());
    history.add(time_ns, row);
  }

  [[nodiscard]] Json description(const std::string& port) const {
    Json fields = Json::array();
    for (const std::size_t i : shown) {
      const recording::Column& column = columns.all()[i];
      Json field{{"name", column.name}};
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
    const bool whole = has == 0 || has > history.newest();  // the latter if the history has begun anew
    const auto rows = history.after(whole ? 0 : has, most);
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
        {"port", port}, {"whole", whole}, {"times_ms", std::move(times)}, {"values", std::move(series)}};
  }

  const dds::Flow flow;
  const recording::Columns columns;
  std::vector<std::size_t> shown;
  Instant asked{};
  Instant used{};

  std::mutex mutex;
  ValueHistory history;
  std::vector<recording::Value> values;  // of the last sample, kept to allocate no memory
  std::vector<double> row;

  std::unique_ptr<dds::Tap> tap;  // the last member, so it is destroyed first and adds no more values
};

WatchedPorts::WatchedPorts(client::Connection& client, Streams& streams)
    : client_(client), streams_(streams) {}
WatchedPorts::~WatchedPorts() = default;

Result<std::shared_ptr<WatchedPorts::Source>> WatchedPorts::source(const std::string& port) {
  {
    const std::lock_guard lock{mutex_};
    if (const auto found = sources_.find(port); found != sources_.end()) return found->second;
  }
  auto flow = client::tapped(*client_.sender, port);
  if (!flow) return flow.problems();
  auto made = std::make_shared<Source>(std::move(*flow));
  if (made->shown.empty())
    return fail(port + " has no numeric field", "use takt echo " + port + " to print its samples");
  made->asked = made->used = os::now();
  auto tap =
      dds::Tap::create(client_.participant, made->flow,
                       [source = made.get()](const std::byte* bytes, std::size_t size, std::int64_t time_ns) {
                         source->add(bytes, size, time_ns);
                       });
  if (!tap) return tap.problems();
  made->tap = std::move(*tap);
  const std::lock_guard lock{mutex_};
  return sources_.try_emplace(port, std::move(made))
      .first->second;  // another thread may have added the port meanwhile
}

Problems WatchedPorts::want(const std::shared_ptr<Stream>& stream, const std::vector<std::string>& ports) {
  Problems problems;
  std::map<std::string, std::int64_t> view;
  for (const std::string& port : ports) {
    if (auto found = source(port); found) {
      view[port] = 0;
      stream->send(event_text("port", model::json_text((*found)->description(port))));
    } else {
      for (Problem problem : found.problems()) {
        problem.where = port;
        problems.push_back(std::move(problem));
      }
    }
  }
  const std::lock_guard lock{mutex_};
  views_[stream->id()] = std::move(view);
  return problems;
}

void WatchedPorts::send() {
  const std::lock_guard lock{mutex_};
  for (auto view = views_.begin(); view != views_.end();) {
    const auto stream = streams_.find(view->first);
    if (!stream || stream->ended()) {
      view = views_.erase(view);
      continue;
    }
    const std::size_t most =
        std::min(kMostOfPort, kMostAtOnce / std::max<std::size_t>(view->second.size(), 1));
    for (auto& [port, has] : view->second) {
      const auto source = sources_.find(port);
      if (source == sources_.end()) continue;
      source->second->used = os::now();
      if (const auto news = source->second->news(port, has, most))
        stream->send(event_text("points", model::json_text(*news)));
    }
    ++view;
  }
}

void WatchedPorts::maintain() {
  std::vector<std::string> again;
  std::vector<std::shared_ptr<Source>>
      gone;  // destroyed after the lock is released, because ~Source waits for a DDS thread
  {
    const std::lock_guard lock{mutex_};
    const Instant now = os::now();
    for (auto source = sources_.begin(); source != sources_.end();) {
      if (now - source->second->used > kUnused) {
        gone.push_back(std::move(source->second));
        source = sources_.erase(source);
        continue;
      }
      if (now - source->second->asked > client::kAskAgain) {
        source->second->asked = now;
        again.push_back(source->first);
      }
      ++source;
    }
  }
  std::vector<std::string> changed;
  for (const std::string& port : again) {
    const auto devices = client_.observer->devices(port.substr(0, port.find('.')));
    if (std::none_of(devices.begin(), devices.end(), [](const wire::ObservedDevice& d) { return d.alive; }))
      continue;
    const auto flow = client::tapped(*client_.sender, port);
    if (!flow) continue;  // the device is lost or still starting; the page shows its state
    const std::lock_guard lock{mutex_};
    const auto source = sources_.find(port);
    if (source == sources_.end()) continue;
    const dds::Flow& before = source->second->flow;
    if (before.topic == flow->topic && before.type == flow->type &&
        before.quality.reliable == flow->quality.reliable) {
      continue;
    }
    gone.push_back(std::move(source->second));  // a new deployment has changed the port
    sources_.erase(source);
    changed.push_back(port);
  }
  for (const std::string& port : changed) resend(port);
}

// Sends the new description of a port to all streams that show the port. send() then sends all of the port's
// values.
void WatchedPorts::resend(const std::string& port) {
  const auto now = source(port);
  if (!now) return;
  const std::string text = event_text("port", model::json_text((*now)->description(port)));
  const std::lock_guard lock{mutex_};
  for (auto& [id, view] : views_) {
    const auto shown = view.find(port);
    const auto stream = streams_.find(id);
    if (shown == view.end() || !stream) continue;
    shown->second = 0;
    stream->send(text);
  }
}

}  // namespace takt::tool::web
