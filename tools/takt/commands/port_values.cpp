#include "commands/port_values.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include <fmt/format.h>

#include <takt/client/tap.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/model/type.hpp>
#include <takt/os/clock.hpp>

#include "watch/short_text.hpp"

namespace takt::tool {

namespace {

/// Samples that arrive sooner after a kept sample are dropped, because the screen is not drawn more often.
constexpr std::chrono::milliseconds kApart{50};

}  // namespace

struct PortValues::Source {
  explicit Source(dds::Flow of) : flow(std::move(of)) {}

  /// DDS calls this on its own thread.
  void add(const std::byte* bytes, std::size_t size) {
    const std::lock_guard lock{mutex};
    const Instant now = os::now();
    if (!sample.empty() && now - at < kApart) return;
    at = now;
    sample.assign(bytes, bytes + size);
  }

  const dds::Flow flow;
  std::mutex mutex;
  Instant at{};
  std::vector<std::byte> sample;
  std::unique_ptr<dds::Tap> tap;  // the last member, so it is destroyed first and adds no more samples
};

PortValues::PortValues(const client::Connection& client) : client_(client), thread_([this] { ask(); }) {}

PortValues::~PortValues() {
  {
    const std::lock_guard lock{mutex_};
    ended_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void PortValues::want(const std::vector<std::string>& ports) {
  std::map<std::string, std::shared_ptr<Source>> gone;  // destroyed after the lock is released
  {
    const std::lock_guard lock{mutex_};
    if (ports == wanted_) return;
    wanted_ = ports;
    for (auto at = sources_.begin(); at != sources_.end();) {
      const auto here = at++;
      if (std::find(ports.begin(), ports.end(), here->first) == ports.end())
        gone.insert(sources_.extract(here));
    }
  }
  changed_.notify_one();
}

std::map<std::string, std::string> PortValues::newest() const {
  std::map<std::string, std::string> values;
  const std::lock_guard lock{mutex_};
  for (const auto& [port, source] : sources_) {
    const std::lock_guard of_source{source->mutex};
    if (source->sample.empty()) continue;
    std::string text = watch::short_text(
        model::sample_json(source->flow.type, source->sample.data(), source->sample.size()));
    const auto age = std::chrono::floor<std::chrono::seconds>(os::now() - source->at);
    if (age > std::chrono::seconds{1}) text += fmt::format(" ({} s ago)", age.count());
    values[port] = std::move(text);
  }
  return values;
}

// Asks for the wanted ports at once when they change, and again every kAskAgain.
void PortValues::ask() {
  std::unique_lock lock{mutex_};
  while (!ended_) {
    const std::vector<std::string> ports = wanted_;
    for (const std::string& port : ports) {
      if (ended_ || ports != wanted_) break;
      lock.unlock();
      std::shared_ptr<Source> made;
      const auto flow = client::tapped(*client_.sender, port);
      if (flow) made = std::make_shared<Source>(*flow);
      lock.lock();
      const auto known = sources_.find(port);
      if (!made || ports != wanted_ ||
          (known != sources_.end() && known->second->flow.topic == made->flow.topic &&
           known->second->flow.type == made->flow.type)) {
        continue;
      }
      lock.unlock();
      auto tap = dds::Tap::create(client_.participant, made->flow,
                                  [source = made.get()](const std::byte* bytes, std::size_t size,
                                                        std::int64_t) { source->add(bytes, size); });
      if (tap) made->tap = std::move(*tap);
      lock.lock();
      if (made->tap && ports == wanted_) std::swap(sources_[port], made);
      lock.unlock();
      made.reset();  // waits for a DDS thread
      lock.lock();
    }
    if (ended_ || ports != wanted_) continue;
    changed_.wait_for(lock, client::kAskAgain, [&] { return ended_ || ports != wanted_; });
  }
}

}  // namespace takt::tool
