#include <takt/client/observer.hpp>

#include <optional>

#include <takt/dds/topics.hpp>

namespace takt::client {

namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

bool same(const DeviceStatus& a, const DeviceStatus& b) {
  return a.path() == b.path() && a.node() == b.node() && a.state() == b.state() && a.health() == b.health() &&
         a.text() == b.text() && a.deployment() == b.deployment() && a.real_time() == b.real_time() &&
         a.host_process_id() == b.host_process_id() && a.host_restarts() == b.host_restarts() &&
         a.modules() == b.modules() && a.executing() == b.executing();
}

}  // namespace

struct Observer::Readers {
  std::optional<dds::Reader<DeviceStatus>> devices;
  std::optional<dds::Reader<LifecycleStatus>> modules;
  std::optional<dds::Reader<ModuleStatistics>> statistics;
  std::optional<dds::Reader<ExecutorStatistics>> executors;
  std::optional<dds::Reader<PortStatus>> ports;
};

Observer::Observer(Options options) : options_(std::move(options)), readers_(std::make_unique<Readers>()) {}

Observer::~Observer() = default;

void Observer::changed(const std::function<void(wire::CellState&)>& change) {
  {
    const std::lock_guard lock{mutex_};
    change(cell_state_);
  }
  changed_.notify_all();
}

void Observer::receive(const DeviceStatus& status, wire::WriterId writer) {
  std::optional<wire::ObservedDevice> news;
  {
    const std::lock_guard lock{mutex_};
    bool known = false;
    for (const wire::ObservedDevice& before : cell_state_.devices(status.device().to_string()))
      known |= before.alive && same(before.status, status);
    cell_state_.receive(status, writer);
    if (known) return;
    for (const wire::ObservedDevice& now : cell_state_.devices(status.device().to_string())) {
      if (now.status.node() == status.node()) news = now;
    }
  }
  changed_.notify_all();
  if (news && options_.news.device) options_.news.device(*news);
}

Result<std::unique_ptr<Observer>> Observer::create(std::shared_ptr<dds::Participant> participant,
                                                   Options options) {
  std::unique_ptr<Observer> observer{new Observer{std::move(options)}};
  Observer* const self = observer.get();
  Readers& readers = *observer->readers_;
  Problems problems;
  const auto keep = [&problems](auto& place, auto reader) {
    if (reader)
      place.emplace(std::move(*reader));
    else
      problems.insert(problems.end(), reader.problems().begin(), reader.problems().end());
  };

  keep(readers.modules, dds::Reader<LifecycleStatus>::create(
                            participant, {.sample =
                                              [self](const LifecycleStatus& status, wire::WriterId) {
                                                self->changed([&](wire::CellState& p) { p.receive(status); });
                                                if (self->options_.news.module)
                                                  self->options_.news.module(status);
                                              },
                                          .disposed =
                                              [self](const LifecycleStatus& key, wire::WriterId) {
                                                self->changed([&](wire::CellState& p) { p.remove(key); });
                                              },
                                          .lost = {}}));
  keep(readers.devices,
       dds::Reader<DeviceStatus>::create(
           participant, {.sample = [self](const DeviceStatus& status,
                                          wire::WriterId writer) { self->receive(status, writer); },
                         .disposed =
                             [self](const DeviceStatus& key, wire::WriterId writer) {
                               self->changed([&](wire::CellState& p) { p.remove(key, writer); });
                             },
                         .lost =
                             [self](wire::WriterId writer) {
                               std::vector<wire::ObservedDevice> lost;
                               self->changed([&](wire::CellState& p) {
                                 lost = p.devices();
                                 p.lost(writer);
                                 const std::vector<wire::ObservedDevice> now = p.devices();
                                 for (std::size_t i = 0; i < now.size(); ++i)
                                   lost[i].alive = lost[i].alive && !now[i].alive;
                               });
                               for (wire::ObservedDevice& device : lost) {
                                 if (!device.alive || !self->options_.news.device) continue;
                                 device.alive = false;
                                 self->options_.news.device(device);
                               }
                             }}));
  if (self->options_.statistics) {
    keep(readers.statistics, dds::Reader<ModuleStatistics>::create(
                                 participant, {.sample = [self](const ModuleStatistics& s, wire::WriterId) {
                                   self->changed([&](wire::CellState& p) { p.receive(s); });
                                 }}));
    keep(readers.executors, dds::Reader<ExecutorStatistics>::create(
                                participant, {.sample = [self](const ExecutorStatistics& s, wire::WriterId) {
                                  self->changed([&](wire::CellState& p) { p.receive(s); });
                                }}));
    keep(readers.ports,
         dds::Reader<PortStatus>::create(participant, {.sample = [self](const PortStatus& s, wire::WriterId) {
                                           self->changed([&](wire::CellState& p) { p.receive(s); });
                                         }}));
  }
  if (!problems.empty()) return problems;
  return observer;
}

std::vector<wire::ObservedDevice> Observer::devices() const {
  const std::lock_guard lock{mutex_};
  return cell_state_.devices();
}

std::vector<wire::ObservedDevice> Observer::devices(const std::string& name) const {
  const std::lock_guard lock{mutex_};
  return cell_state_.devices(name);
}

bool Observer::wait(const std::function<bool(const std::vector<wire::ObservedDevice>&)>& condition,
                    Nanoseconds limit) const {
  const auto end = Clock::now() + limit;
  while (!condition(devices())) {
    if (Clock::now() >= end) return false;
    std::unique_lock lock{mutex_};
    changed_.wait_for(lock, milliseconds{20});
  }
  return true;
}

void Observer::settle(Nanoseconds limit) const {
  const auto begin = Clock::now();
  std::size_t found = 0;
  auto since = begin;
  wait(
      [&](const std::vector<wire::ObservedDevice>& devices) {
        const auto now = Clock::now();
        if (devices.size() != found) since = now;
        found = devices.size();
        return found != 0 && now - since >= kQuiet;
      },
      limit);
}

}  // namespace takt::client
