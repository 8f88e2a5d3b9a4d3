#include "dds_publisher.hpp"

#include <atomic>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include <takt/dds/topics.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/real_time.hpp>
#include "heartbeat.hpp"
#include "outbox.hpp"

namespace takt::node {

namespace {

using std::chrono::milliseconds;

/// Often enough for the lease of takt/lifecycle.
constexpr milliseconds kAssertEvery{100};
/// Between two looks for interfaces that have come up.
constexpr Nanoseconds kRescanEvery = std::chrono::seconds{2};
/// Events that wait to be said; of more the oldest are left to the record.
constexpr std::size_t kMostFaults = 1024;
/// At the end, for observers to hear that this node leaves.
constexpr milliseconds kFarewell{200};

class ToDevice final : public DeviceLine {
 public:
  explicit ToDevice(dds::Writer<DeviceStatus> writer) : writer_(std::move(writer)) {}
  void write(const DeviceStatus& status) override { writer_.write(status); }
  void dispose(const DeviceStatus& key) override { writer_.dispose(key); }
  void farewell() { writer_.wait_acknowledged(kFarewell); }

 private:
  dds::Writer<DeviceStatus> writer_;
};

class ToLifecycle final : public LifecycleLine {
 public:
  explicit ToLifecycle(dds::Writer<LifecycleStatus> writer) : writer_(std::move(writer)) {}
  bool write(const LifecycleStatus& status) override { return writer_.write(status); }
  void dispose(const LifecycleStatus& key) override { writer_.dispose(key); }
  bool wait_acknowledged(milliseconds limit) override { return writer_.wait_acknowledged(limit); }
  void assert_liveliness() { writer_.assert_liveliness(); }

 private:
  dds::Writer<LifecycleStatus> writer_;
};

}  // namespace

struct DdsPublisher::Inside {
  Inside(std::shared_ptr<dds::Participant> p, dds::Writer<DeviceStatus> d, dds::Writer<LifecycleStatus> l,
         dds::Writer<ModuleStatistics> m, dds::Writer<ExecutorStatistics> e, dds::Writer<PortStatus> s,
         dds::Writer<FaultEvent> f)
      : participant(std::move(p)),
        device(std::move(d)),
        lifecycle(std::move(l)),
        modules(std::move(m)),
        executors(std::move(e)),
        ports(std::move(s)),
        faults(std::move(f)) {}

  // On the heartbeat's thread.
  void beat() {
    while (!end) heartbeat.serve(device);
    heartbeat.leave(device);
    device.farewell();
  }

  // On the other: transitions first, then what is left.
  void tell() {
    Instant asserted{};
    Instant scanned = os::now();
    while (!end) {
      const bool said = outbox.serve(lifecycle, kAssertEvery / 2);
      const Instant now = os::now();
      if (now - asserted >= kAssertEvery) {
        asserted = now;
        lifecycle.assert_liveliness();
      }
      if (said) continue;
      tell_faults();
      tell_measures();
      if (now - scanned >= kRescanEvery) {
        scanned = now;
        participant->rescan_interfaces();
      }
    }
    const Instant limit = os::now() + kFarewell;
    while (os::now() < limit && outbox.serve(lifecycle, milliseconds{0})) {
    }
    tell_faults();
    tell_measures();
    lifecycle.wait_acknowledged(kFarewell);
    faults.wait_acknowledged(kFarewell);
  }

  void tell_faults() {
    std::deque<FaultEvent> news;
    {
      const std::lock_guard lock{mutex};
      news.swap(unsaid);
    }
    for (const FaultEvent& event : news) faults.write(event);
  }

  void tell_measures() {
    std::optional<Measures> news;
    Measures over;
    {
      const std::lock_guard lock{mutex};
      news = std::exchange(measures, std::nullopt);
      over = std::exchange(taken_back, {});
    }
    const auto dispose = [](auto& writer, const auto& list) {
      for (const auto& entry : list) writer.dispose(entry);
    };
    dispose(modules, over.modules);
    dispose(executors, over.executors);
    dispose(ports, over.ports);
    if (!news) return;
    for (const auto& entry : news->modules) modules.write(entry);
    for (const auto& entry : news->executors) executors.write(entry);
    for (const auto& entry : news->ports) ports.write(entry);
  }

  std::shared_ptr<dds::Participant> participant;
  ToDevice device;
  ToLifecycle lifecycle;
  dds::Writer<ModuleStatistics> modules;
  dds::Writer<ExecutorStatistics> executors;
  dds::Writer<PortStatus> ports;
  dds::Writer<FaultEvent> faults;
  std::function<void(const dds::WholeReply&)> replies;
  Heartbeat heartbeat;
  Outbox outbox;
  std::mutex mutex;
  std::optional<Measures> measures;
  Measures taken_back;
  std::deque<FaultEvent> unsaid;
  std::atomic<bool> end{false};
  os::Thread beats;  // last: joined before anything that they use is gone
  os::Thread tells;
};

DdsPublisher::DdsPublisher(std::unique_ptr<Inside> inside) noexcept : inside_(std::move(inside)) {}

Result<std::unique_ptr<DdsPublisher>> DdsPublisher::create(std::shared_ptr<dds::Participant> participant) {
  auto device = dds::Writer<DeviceStatus>::create(participant);
  auto lifecycle = dds::Writer<LifecycleStatus>::create(participant);
  auto modules = dds::Writer<ModuleStatistics>::create(participant);
  auto executors = dds::Writer<ExecutorStatistics>::create(participant);
  auto ports = dds::Writer<PortStatus>::create(participant);
  auto faults = dds::Writer<FaultEvent>::create(participant);
  Problems problems;
  const auto check = [&problems](const auto& writer) {
    if (!writer) problems.insert(problems.end(), writer.problems().begin(), writer.problems().end());
  };
  check(device);
  check(lifecycle);
  check(modules);
  check(executors);
  check(ports);
  check(faults);
  if (!problems.empty()) return problems;
  auto inside = std::make_unique<Inside>(std::move(participant), std::move(*device), std::move(*lifecycle),
                                         std::move(*modules), std::move(*executors), std::move(*ports),
                                         std::move(*faults));
  Inside* const place = inside.get();
  auto beats = os::Thread::start(
      {.name = "takt-heartbeat"}, [place] { place->beat(); }, nullptr);
  if (!beats) return beats.problems();
  inside->beats = std::move(*beats);
  auto tells = os::Thread::start(
      {.name = "takt-dds_publisher"}, [place] { place->tell(); }, nullptr);
  if (!tells) {
    inside->end = true;
    return tells.problems();
  }
  inside->tells = std::move(*tells);
  return std::unique_ptr<DdsPublisher>{new DdsPublisher{std::move(inside)}};
}

DdsPublisher::~DdsPublisher() {
  inside_->end = true;
  inside_->outbox.wake();
  inside_->heartbeat.wake();
  inside_->beats.join();
  inside_->tells.join();
}

void DdsPublisher::answer_by(std::function<void(const dds::WholeReply&)> replies) {
  inside_->replies = std::move(replies);
}

void DdsPublisher::sign() { inside_->heartbeat.sign(os::now()); }

void DdsPublisher::reply(const dds::WholeReply& reply) { inside_->replies(reply); }

void DdsPublisher::say(const LifecycleStatus& status) { inside_->outbox.put(status); }

void DdsPublisher::say(const DeviceStatus& status) { inside_->heartbeat.set(status); }

void DdsPublisher::say(const Measures& measures) {
  {
    const std::lock_guard lock{inside_->mutex};
    inside_->measures = measures;
  }
  inside_->outbox.wake();
}

void DdsPublisher::say(const FaultEvent& event) {
  {
    const std::lock_guard lock{inside_->mutex};
    inside_->unsaid.push_back(event);
    if (inside_->unsaid.size() > kMostFaults) inside_->unsaid.pop_front();
  }
  inside_->outbox.wake();
}

void DdsPublisher::take_back(const std::vector<LifecycleStatus>& modules, const Measures& measures) {
  for (const LifecycleStatus& module : modules) inside_->outbox.put_disposal(module);
  {
    const std::lock_guard lock{inside_->mutex};
    inside_->measures.reset();
    inside_->taken_back = measures;
  }
  inside_->outbox.wake();
}

}  // namespace takt::node
