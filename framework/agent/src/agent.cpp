#include <takt/agent/agent.hpp>

#include <algorithm>
#include <utility>

#include <takt/wire/fault.hpp>
#include <takt/wire/words.hpp>
#include "limits.hpp"
#include "update.hpp"

namespace takt::agent {

using Phase = Supervised::Phase;

Agent::Agent(Options options, Factories factories, Publisher& publisher)
    : options_(std::move(options)),
      factories_(std::move(factories)),
      publisher_(publisher),
      began_(options_.now()),
      stepped_at_(began_),
      filter_([this](model::Fault fault) {
        FaultMemory& record = *options_.record;
        const bool kept = !record.file().empty();
        record.append(fault);
        if (kept && record.file().empty())
          log("warning: the fault record is only in memory now: " + in_words(record.problems()));
        alarms_.take(fault);
        publisher_.publish(wire::to_wire(fault));
      }) {
  for (const model::Fault& fault : options_.record->events()) alarms_.take(fault);
  if (!options_.store) return;
  if (const auto kept = options_.store->undeployed())
    undeployed_ = *kept;
  else
    log("warning: " + in_words(kept.problems()));
}

Agent::~Agent() = default;

void Agent::log(const std::string& text) const { options_.log(text); }

void Agent::end(bool at_once) {
  at_once_ |= at_once;
  if (ending_) return;
  ending_ = true;
  if (update_) update_->drop("its node is shutting down");
  if (!deployment_) return;
  if (deployment_->supervised)
    stop();
  else
    abandon({fail("its node is shutting down")});
}

bool Agent::ended() const {
  if (!ending_) return false;
  if ((deployment_ && !deployment_->over) || !is_saved()) return false;
  // `takt run` closes the lifetime descriptor once it has received the final report. Until then, the answer
  // to `takt run` may still be on its way.
  return at_once_ || !options_.temporary || !ended_at_ || options_.now() - *ended_at_ > kReportFetched;
}

void Agent::step() {
  const Instant last = std::exchange(stepped_at_, options_.now());
  if (stepped_at_ - last > kLease) {
    stood_still_for_ = std::chrono::floor<std::chrono::milliseconds>(stepped_at_ - last);
    stood_still_until_ = stepped_at_;
  }
  check_names();
  check_interruption();
  check_devices();
  check_clocks();
  check_cell();
  check_undeployed();
  check_saved();
  check_disk();
  check_inspection();
  step_gone();
  step_supervised();
  check_description();
  check_swap();
  if (update_) update_->step();
  publish_status();
  publish_measures();
  filter_.step(options_.now());
}

// Stops this device when a failure stops the whole cell. The loss of a device that has a stop-cell module
// counts as such a failure, because a lost device cannot report a failure. If this device has a stop-cell
// module, it also stops when it loses contact with all other devices, because they treat this device as lost.
void Agent::check_cell() {
  if (!deployment_ || !deployment_->supervised) return;
  const Deployment& d = *deployment_;
  const Phase phase = d.supervised->phase();
  if (phase != Phase::ready && phase != Phase::running) return;
  const auto stop = [&d](const std::string& device, const std::string& what, const std::string& fix = {}) {
    d.supervised->stop_for({"device " + device, what, fix});
  };
  constexpr const char* kCure = "check its machine and network, then undeploy the cell and deploy it again";
  std::string lost;
  bool alone = true;
  for (const wire::CellState::LastStatus& other : others_.of_deployment(d.id, options_.device)) {
    const std::string name = other.status.device().to_string();
    if (other.status.stops_cell())
      return stop(options_.device, "stops with its cell: " + other.status.text().to_string());
    const DeviceState state = other.status.state();
    const bool ran =
        state == DEVICE_READY || state == DEVICE_ARMED || state == DEVICE_STARTED || state == DEVICE_RUNNING;
    if (other.alive) alone = false;
    if (other.alive || !ran) continue;
    const auto device = std::find_if(d.cell.devices.begin(), d.cell.devices.end(),
                                     [&name](const model::Device& one) { return one.name == name; });
    if (device != d.cell.devices.end() && model::stops_cell(*device))
      return stop(name, "is lost, and one of its modules stops the cell when it fails", kCure);
    lost += (lost.empty() ? "" : ", ") + name;
  }
  if (alone && !lost.empty() && model::stops_cell(d.of_device()))
    stop(options_.device, "has lost " + lost + ", and one of its modules stops the cell when it fails",
         kCure);
}

DeviceStatus Agent::status() const {
  DeviceStatus status;
  const Deployment* const d = present();
  const std::string cell = d == nullptr ? std::string{wire::kNoCell} : d->cell.name;
  wire::set(status.path(), wire::path_of(cell, options_.device));
  wire::set(status.cell(), cell);
  wire::set(status.device(), options_.device);
  wire::set(status.node(), options_.node);
  wire::set(status.host_name(), options_.host_name);
  status.process_id(options_.process_id);
  status.state(DEVICE_WAITING);
  status.health(HEALTH_OK);
  status.real_time(options_.real_time);
  std::string text = name_clash_;
  if (!name_clash_.empty()) status.health(HEALTH_DEGRADED);
  if ((d == nullptr || !d->supervised) && !last_refusal_.empty()) {
    status.health(HEALTH_FAILED);
    text = last_refusal_;
  }
  if (d != nullptr) {
    wire::set(status.deployment(), d->id);
    status.state(d->over ? DEVICE_ENDED : DEVICE_PREPARING);
    status.uninterrupted_s(static_cast<std::uint32_t>(uninterrupted().count()));
    status.modules(static_cast<std::uint32_t>(d->of_device().modules.size()));
  }
  if (d != nullptr && d->supervised) {
    const Supervised& supervised = *d->supervised;
    const Standing standing = supervised.standing();
    // The new deployment of an update that is not final
    const transaction::State* const begins =
        update_ && update_->is_after() ? &update_->transaction().state : nullptr;
    status.real_time(standing.real_time);
    status.host_process_id(standing.host_pid);
    status.host_restarts(standing.host_restarts);
    status.executing(standing.executing);
    // Before T0, no module has run that could stop the cell.
    const bool has_run = d->began && (begins == nullptr || time_of(update_->transaction()) >= begins->t0_ns);
    switch (supervised.phase()) {
      case Phase::preparing:
        break;
      case Phase::ready:
        status.state(begins == nullptr || begins->stage == transaction::Stage::prepared ? DEVICE_READY
                                                                                        : DEVICE_ARMED);
        break;
      case Phase::running:
        status.state(begins == nullptr ? DEVICE_RUNNING : has_run ? DEVICE_STARTED : DEVICE_ARMED);
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
      status.stops_cell(has_run && supervised.stops_cell());
      text = to_text(supervised.failures()[0]);
    } else if (!ends && !standing.faulty.empty()) {
      status.health(HEALTH_DEGRADED);
      if (text.empty()) text = standing.faulty;
    }
  }
  if (text.empty() && update_) text = update_->progress();
  wire::set(status.text(), text);
  wire::set(status.undeployed(), undeployed_but_held());
  if (const Transaction* const newest = newest_transaction(); newest != nullptr) {
    wire::set(status.transaction(), newest->id);
    // Another device may rely on it that an update is final only when this is on disk.
    const bool unsaved = update_ && newest->state.stage == transaction::Stage::final;
    status.stage(unsaved ? STAGE_RUNNING : static_cast<TransactionStage>(newest->state.stage));
    status.t0_ns(newest->state.t0_ns);
  }
  add_clock(status);
  return status;
}

void Agent::publish_status() {
  DeviceStatus now = status();
  update_alarms(now);
  const auto same = [this, &now](auto&&... part) { return ((part(published_) == part(now)) && ...); };
  if (published_once_ &&
      same([](const auto& s) { return s.path(); }, [](const auto& s) { return s.state(); },
           [](const auto& s) { return s.health(); }, [](const auto& s) { return s.text(); },
           [](const auto& s) { return s.deployment(); }, [](const auto& s) { return s.t0_ns(); },
           [](const auto& s) { return s.uninterrupted_s(); }, [](const auto& s) { return s.undeployed(); },
           [](const auto& s) { return s.transaction(); }, [](const auto& s) { return s.stage(); },
           [](const auto& s) { return s.real_time(); }, [](const auto& s) { return s.host_process_id(); },
           [](const auto& s) { return s.host_restarts(); }, [](const auto& s) { return s.modules(); },
           [](const auto& s) { return s.executing(); }, [](const auto& s) { return s.alarm_changes(); })) {
    return;
  }
  published_ = now;
  published_once_ = true;
  publisher_.publish(now);
}

void Agent::publish_measures() {
  if (!deployment_ || !deployment_->supervised || deployment_->over) return;
  const Instant now = options_.now();
  if (now - measured_at_ < kMeasuresEvery) return;
  measured_at_ = now;
  ++measures_published_;
  Measures measures = deployment_->supervised->measures();
  const auto stamp = [this](auto& list) {
    for (auto& entry : list) {
      entry.sequence_number(measures_published_);
      entry.time_ns(options_.wall_ns());
    }
  };
  stamp(measures.modules);
  stamp(measures.executors);
  stamp(measures.ports);
  publisher_.publish(measures);
}

}  // namespace takt::agent
