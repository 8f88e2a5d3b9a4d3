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

/// The interval at which the publisher asserts the liveliness of takt/lifecycle. This interval must be
/// shorter than the lease of the topic.
constexpr milliseconds kAssertEvery{100};
/// The interval at which the participant looks for new network interfaces.
/// The maximum number of fault events that wait to be published. If there are more, the oldest events are not
/// published, and stay only in the fault record.
constexpr std::size_t kMostFaults = 1024;
/// The time that a node waits at shutdown, so that observers receive its last samples and the withdrawal of
/// its status.
constexpr milliseconds kFarewell{200};

class DeviceWriter final : public DeviceSink {
 public:
  explicit DeviceWriter(dds::Writer<DeviceStatus> writer) : writer_(std::move(writer)) {}
  void write(const DeviceStatus& status) override { writer_.write(status); }
  void dispose(const DeviceStatus& key) override { writer_.dispose(key); }
  void farewell() { writer_.wait_acknowledged(kFarewell); }

 private:
  dds::Writer<DeviceStatus> writer_;
};

class LifecycleWriter final : public LifecycleSink {
 public:
  explicit LifecycleWriter(dds::Writer<LifecycleStatus> writer) : writer_(std::move(writer)) {}
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

  // Runs on the thread `takt-heartbeat`. Publishes the device's status until the end, then withdraws it.
  void run_heartbeat() {
    while (!end) heartbeat.serve(device);
    heartbeat.leave(device);
    device.farewell();
  }

  // Runs on the thread `takt-publisher`. Publishes lifecycle transitions first, then fault events and
  // statistics.
  void run_publisher() {
    Instant asserted{};
    while (!end) {
      const bool sent = outbox.serve(lifecycle, kAssertEvery / 2);
      const Instant now = os::now();
      if (now - asserted >= kAssertEvery) {
        asserted = now;
        lifecycle.assert_liveliness();
      }
      if (sent) continue;
      write_faults();
      write_measures();
    }
    const Instant limit = os::now() + kFarewell;
    while (os::now() < limit && outbox.serve(lifecycle, milliseconds{0})) {
    }
    write_faults();
    write_measures();
    lifecycle.wait_acknowledged(kFarewell);
    faults.wait_acknowledged(kFarewell);
  }

  void write_faults() {
    std::deque<FaultEvent> news;
    {
      const std::lock_guard lock{mutex};
      news.swap(pending_faults);
    }
    for (const FaultEvent& event : news) faults.write(event);
  }

  void write_measures() {
    std::optional<supervision::Measures> news;
    supervision::Measures over;
    {
      const std::lock_guard lock{mutex};
      news = std::exchange(measures, std::nullopt);
      over = std::exchange(withdrawn, {});
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
  DeviceWriter device;
  LifecycleWriter lifecycle;
  dds::Writer<ModuleStatistics> modules;
  dds::Writer<ExecutorStatistics> executors;
  dds::Writer<PortStatus> ports;
  dds::Writer<FaultEvent> faults;
  std::function<void(const wire::WholeReply&)> replies;
  Heartbeat heartbeat;
  Outbox outbox;
  std::mutex mutex;
  std::optional<supervision::Measures> measures;
  supervision::Measures withdrawn;
  std::deque<FaultEvent> pending_faults;
  std::atomic<bool> end{false};
  // The threads are the last members, so that they are joined before the other members are destroyed.
  os::Thread heartbeat_thread;
  os::Thread publisher_thread;
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
  auto heartbeat_thread = os::Thread::start(
      {.name = "takt-heartbeat"}, [place] { place->run_heartbeat(); }, nullptr);
  if (!heartbeat_thread) return heartbeat_thread.problems();
  inside->heartbeat_thread = std::move(*heartbeat_thread);
  auto publisher_thread = os::Thread::start(
      {.name = "takt-publisher"}, [place] { place->run_publisher(); }, nullptr);
  if (!publisher_thread) {
    inside->end = true;
    return publisher_thread.problems();
  }
  inside->publisher_thread = std::move(*publisher_thread);
  return std::unique_ptr<DdsPublisher>{new DdsPublisher{std::move(inside)}};
}

DdsPublisher::~DdsPublisher() {
  inside_->end = true;
  inside_->outbox.wake();
  inside_->heartbeat.wake();
  inside_->heartbeat_thread.join();
  inside_->publisher_thread.join();
}

void DdsPublisher::set_reply_sender(std::function<void(const wire::WholeReply&)> replies) {
  inside_->replies = std::move(replies);
}

void DdsPublisher::kick() { inside_->heartbeat.kick(os::now()); }

void DdsPublisher::heard(const DeviceStatus& status, Instant arrived) {
  inside_->heartbeat.heard(status.node().to_string(), status.monotonic_ns(), arrived);
}

void DdsPublisher::reply(const wire::WholeReply& reply) { inside_->replies(reply); }

void DdsPublisher::publish(const LifecycleStatus& status) { inside_->outbox.put(status); }

void DdsPublisher::publish(const DeviceStatus& status) { inside_->heartbeat.set(status); }

void DdsPublisher::publish(const supervision::Measures& measures) {
  {
    const std::lock_guard lock{inside_->mutex};
    inside_->measures = measures;
  }
  inside_->outbox.wake();
}

void DdsPublisher::publish(const FaultEvent& event) {
  {
    const std::lock_guard lock{inside_->mutex};
    inside_->pending_faults.push_back(event);
    if (inside_->pending_faults.size() > kMostFaults) inside_->pending_faults.pop_front();
  }
  inside_->outbox.wake();
}

void DdsPublisher::withdraw(const std::vector<LifecycleStatus>& modules,
                            const supervision::Measures& measures) {
  for (const LifecycleStatus& module : modules) inside_->outbox.put_disposal(module);
  {
    const std::lock_guard lock{inside_->mutex};
    inside_->measures.reset();
    inside_->withdrawn = measures;
  }
  inside_->outbox.wake();
}

}  // namespace takt::node
