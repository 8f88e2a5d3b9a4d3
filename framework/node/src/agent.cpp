#include "agent.hpp"

#include <algorithm>

#include <takt/dds/fault.hpp>
#include <takt/dds/words.hpp>
#include <takt/node/log.hpp>
#include <takt/os/environment.hpp>
#include "agent_update.hpp"
#include "limits.hpp"

namespace takt::node {

using Phase = Supervised::Phase;

Agent::Agent(Options options, Workshop workshop, Publisher& publisher)
    : options_(std::move(options)),
      workshop_(std::move(workshop)),
      publisher_(publisher),
      began_(options_.now()),
      filter_([this](model::Fault fault) {
        FaultRecord& record = *options_.record;
        const bool kept = !record.file().empty();
        record.append(fault);
        if (kept && record.file().empty())
          log("warning: the fault record goes on in memory alone: " + in_words(record.problems()));
        publisher_.say(dds::to_wire(fault));
      }) {
  if (!options_.record) options_.record = std::make_shared<FaultRecord>();
}

Agent::~Agent() = default;

void Agent::log(const std::string& text) const { node::log(options_.device, "", text); }

void Agent::end(bool at_once) {
  at_once_ |= at_once;
  if (ending_) return;
  ending_ = true;
  drop_update("its node was told to end");
  if (!deployment_) return;
  if (deployment_->supervised)
    deployment_->supervised->stop();
  else
    refuse({fail("its node was told to end")});
}

bool Agent::ended() const {
  if (!ending_) return false;
  if (deployment_ && !deployment_->over) return false;
  // Who started it closes what it was lent by when the report is there; until then the answer is on its way.
  return at_once_ || !options_.lent || !ended_at_ || options_.now() - *ended_at_ > kReportFetched;
}

std::vector<const os::Fd*> Agent::wait_on() {
  if (!deployment_) return {};
  if (deployment_->inspection) return {&deployment_->inspection->fd()};
  return deployment_->supervised->wait_on();
}

void Agent::step() {
  watch_names();
  watch_devices();
  watch_cell();
  watch_disk();
  look_at_inspection();
  look_at_supervised();
  look_at_description();
  look_at_swap();
  look_at_update();
  tell_status();
  tell_measures();
  filter_.step(options_.now());
}

// Two nodes of one name would both answer, and a cell would run on one of them or on both.
void Agent::watch_names() {
  std::string clash;
  for (const dds::ObservedDevice& other : others_.devices(options_.device)) {
    if (!other.alive || other.node() == options_.node) continue;
    clash = "another node of the name " + options_.device + " is on domain " +
            std::to_string(options_.domain) + ": process " + std::to_string(other.status.process_id()) +
            " on " + other.status.host_name().to_string();
  }
  if (clash == clash_) return;
  log(clash.empty()
          ? "the other node of this name is gone"
          : clash +
                "; end one of them, or give it another name: while there are two, neither is deployed to");
  clash_ = clash;
}

// A fault that is the whole cell's stops this device too. So does the loss of a device that would have to say
// so; and who would have to say so himself and hears nobody any more is such a loss to the others.
void Agent::watch_cell() {
  if (!deployment_ || !deployment_->supervised) return;
  const Deployment& d = *deployment_;
  const Phase phase = d.supervised->phase();
  if (phase != Phase::ready && phase != Phase::running) return;
  const auto stop = [&d](const std::string& device, const std::string& what, const std::string& fix = {}) {
    d.supervised->stop_for({"device " + device, what, fix});
  };
  constexpr const char* kCable = "see to its machine and network, then undeploy the cell and deploy it again";
  std::string lost;
  bool alone = true;
  for (const dds::CellState::Heard& other : others_.of_deployment(d.id, options_.device)) {
    const std::string name = other.status.device().to_string();
    if (other.status.stops_cell())
      return stop(options_.device, "stops with its cell: " + other.status.text().to_string());
    const DeviceState state = other.status.state();
    const bool ran = state == DEVICE_READY || state == DEVICE_RUNNING;
    if (other.alive) alone = false;
    if (other.alive || !ran) continue;
    const auto device = std::find_if(d.cell.devices.begin(), d.cell.devices.end(),
                                     [&name](const model::Device& one) { return one.name == name; });
    if (device != d.cell.devices.end() && model::stops_cell(*device))
      return stop(name, "is lost, and has a module whose fault stops the cell", kCable);
    lost += (lost.empty() ? "" : ", ") + name;
  }
  if (alone && !lost.empty() && model::stops_cell(d.of_device()))
    stop(options_.device, "has lost " + lost + ", and has a module whose fault stops the cell", kCable);
}

DeviceStatus Agent::status() const {
  DeviceStatus status;
  const Deployment* const d = deployment_.get();
  const std::string cell = d == nullptr ? std::string{dds::kNoCell} : d->cell.name;
  dds::set(status.path(), dds::path_of(cell, options_.device));
  dds::set(status.cell(), cell);
  dds::set(status.device(), options_.device);
  dds::set(status.node(), options_.node);
  dds::set(status.host_name(), os::host_name());
  status.process_id(os::process_id());
  status.state(DEVICE_WAITING);
  status.health(HEALTH_OK);
  status.real_time(options_.real_time);
  std::string text = clash_;
  if (!clash_.empty()) status.health(HEALTH_DEGRADED);
  if (d == nullptr && !last_refusal_.empty()) {
    status.health(HEALTH_FAILED);
    text = last_refusal_;
  }
  if (d != nullptr) {
    dds::set(status.deployment(), d->id);
    status.state(DEVICE_PREPARING);
    status.modules(static_cast<std::uint32_t>(d->of_device().modules.size()));
  }
  if (d != nullptr && d->supervised) {
    const Supervised& supervised = *d->supervised;
    const Standing standing = supervised.standing();
    status.real_time(standing.real_time);
    status.host_process_id(standing.host_pid);
    status.host_restarts(standing.host_restarts);
    status.executing(standing.executing);
    switch (supervised.phase()) {
      case Phase::preparing:
        break;
      case Phase::ready:
        status.state(DEVICE_READY);
        break;
      case Phase::running:
        status.state(DEVICE_RUNNING);
        break;
      case Phase::stopping:
        status.state(DEVICE_STOPPING);
        break;
      case Phase::ended:
        status.state(DEVICE_ENDED);
        break;
    }
    const bool ends = supervised.phase() == Phase::stopping || supervised.phase() == Phase::ended;
    if (ends && !supervised.failures().empty()) {
      status.health(HEALTH_FAILED);
      status.stops_cell(supervised.stops_cell());
      text = to_text(supervised.failures()[0]);
    } else if (!ends && !standing.astray.empty()) {
      status.health(HEALTH_DEGRADED);
      if (text.empty()) text = standing.astray;
    }
  }
  dds::set(status.text(), text);
  return status;
}

void Agent::tell_status() {
  const DeviceStatus now = status();
  const auto same = [this, &now](auto&&... part) { return ((part(told_) == part(now)) && ...); };
  if (told_once_ &&
      same([](const auto& s) { return s.path(); }, [](const auto& s) { return s.state(); },
           [](const auto& s) { return s.health(); }, [](const auto& s) { return s.text(); },
           [](const auto& s) { return s.deployment(); }, [](const auto& s) { return s.real_time(); },
           [](const auto& s) { return s.host_process_id(); }, [](const auto& s) { return s.host_restarts(); },
           [](const auto& s) { return s.modules(); }, [](const auto& s) { return s.executing(); })) {
    return;
  }
  told_ = now;
  told_once_ = true;
  publisher_.say(now);
}

void Agent::tell_measures() {
  if (!deployment_ || !deployment_->supervised || deployment_->over) return;
  const Instant now = options_.now();
  if (now - measured_at_ < kMeasuresEvery) return;
  measured_at_ = now;
  ++measures_told_;
  Measures measures = deployment_->supervised->measures();
  const auto stamp = [this](auto& list) {
    for (auto& entry : list) {
      entry.sequence_number(measures_told_);
      entry.time_ns(options_.wall_ns());
    }
  };
  stamp(measures.modules);
  stamp(measures.executors);
  stamp(measures.ports);
  publisher_.say(measures);
}

}  // namespace takt::node
