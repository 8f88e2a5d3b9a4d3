#include <takt/node/device_platform.hpp>

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/channel/violations.hpp>
#include <takt/node/flow_manager.hpp>
#include <takt/node/log.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/machine.hpp>
#include <takt/os/real_time.hpp>
#include <takt/os/thread_use.hpp>
#include <takt/os/waker.hpp>
#include <takt/schedule/placement.hpp>
#include <takt/supervision/parts.hpp>
#include "conditions.hpp"
#include "host_process.hpp"
#include "program_process.hpp"

namespace takt::node {

using supervision::Detection;

DevicePlatform::DevicePlatform(Options options) : options_(std::move(options)) {}
DevicePlatform::~DevicePlatform() = default;

Instant DevicePlatform::now() const { return os::now(); }

void DevicePlatform::log(const std::string& module, const std::string& text) {
  node::log(parts_->of_device().name, module, text);
}

Result<void> DevicePlatform::begin(supervision::Parts& parts) {
  parts_ = &parts;
  const model::Device& device = parts.of_device();
  os::raise_descriptor_limit();
  if (const auto allowed = os::may_be_real_time(); !allowed) {
    parts.real_time = false;
    Problems problems = allowed.problems();
    for (Problem& problem : problems) problem.where = "device " + device.name;
    if (options_.require_real_time) return problems;
    log("", "WARNING: not real-time: " + in_words(allowed.problems()));
  }
  throttling_ = os::read_throttling();
  seen_latest_ns_.assign(device.executors.size(), 0);
  throttled_.assign(device.executors.size(), false);
  const Conditions conditions{.throttling = throttling_,
                              .prioritised = os::may_have_priority().ok(),
                              .memory_locked = os::may_lock_memory().ok(),
                              .swap_bytes = os::read_swap_bytes().value_or(0),
                              .timer_resolution = os::timer_resolution(),
                              .wake_ups = options_.wake_ups};
  for (const std::string& warning : warnings_for(device, parts.plan, conditions))
    log("", "warning: " + warning);
  parts.placement = schedule::place(device, os::read_cpus());
  for (const std::string& warning : parts.placement.warnings) log("", "warning: " + warning);

  if (options_.check_real_time) {
    auto violations = Violations::create(device.modules.size(), device.executors.size());
    if (!violations) return violations.problems();
    violations_ = std::move(*violations);
  }
  if (auto recorded = start_record(); !recorded) return recorded;
  return retain();
}

Result<void> DevicePlatform::start_record() {
  const model::Device& device = parts_->of_device();
  FlightRecorder::Options options{.cell = parts_->cell.name,
                                  .device = device.name,
                                  .modules = {},
                                  .executors = {},
                                  .files = options_.traces};
  for (const model::Executor& executor : device.executors) options.executors.push_back(executor.name);
  for (std::size_t m = 0; m < device.modules.size(); ++m) {
    const model::Module& module = device.modules[m];
    options.modules.push_back({.name = module.name,
                               .process = module.type == model::ModuleType::process,
                               .budget = module.budget.value_or(Nanoseconds{0})});
    if (!parts_->ports[m]) continue;
    for (const model::Port& port : *parts_->ports[m]) options.modules.back().ports.push_back(port.name);
  }
  auto recorder = FlightRecorder::create(std::move(options), parts_->plan, parts_->channel);
  if (!recorder) return recorder.problems();
  flight_ = std::move(*recorder);
  return {};
}

// Loads the saved state of modules with <retain> from disk, and starts to write this state to disk when it
// changes. If a file cannot be read, the node prints a warning, and the module starts without saved state.
Result<void> DevicePlatform::retain() {
  const model::Device& device = parts_->of_device();
  std::vector<Retained::One> all;
  for (std::uint32_t i = 0; i < device.modules.size(); ++i) {
    const model::Module& module = device.modules[i];
    if (!module.retain || options_.state_folder.empty()) continue;
    SavedFile file{options_.state_folder, parts_->cell.name, device.name, module.name};
    channel::SavedState& state = parts_->saved_of(i);
    if (const auto read = file.read_into(state); !read)
      log(module.name, "warning: " + in_words(read.problems()));
    all.push_back({.file = std::move(file), .state = &state, .written = state.whole.load()});
  }
  if (all.empty()) return {};
  auto retained = Retained::start(
      std::move(all), [name = device.name](const std::string& text) { node::log(name, "", text); });
  if (!retained) return retained.problems();
  retained_ = std::move(*retained);
  return {};
}

Nanoseconds DevicePlatform::spin_limit(const model::Module& module, Nanoseconds period) const {
  return os::margin_cap(period, parts_->of_device().executors[parts_->executor_of(module)].spin_share);
}

std::unique_ptr<supervision::Host> DevicePlatform::make_host(std::size_t share) {
  auto process = std::make_unique<HostProcess>(*parts_, share, [this] {
    Inheritance inheritance;
    if (violations_) inheritance.environment = violations_->environment(inheritance.descriptors);
    inheritance.descriptors.push_back(&flight_->fd());
    inheritance.environment.emplace_back("TAKT_FLIGHT_FD", std::to_string(flight_->fd().get()));
    return inheritance;
  });
  hosts_.push_back(process.get());
  return process;
}

std::unique_ptr<supervision::Program> DevicePlatform::make_program(std::uint32_t module) {
  auto process = std::make_unique<ProgramProcess>(*parts_, module, [this, module] {
    Inheritance inheritance;
    if (!violations_) return inheritance;
    inheritance.environment = violations_->environment(inheritance.descriptors);
    inheritance.environment.emplace_back(channel::kCheckModule, std::to_string(module));
    return inheritance;
  });
  programs_.push_back(process.get());
  return process;
}

Result<std::unique_ptr<supervision::Flows>> DevicePlatform::open_flows() {
  std::unique_ptr<supervision::Flows> flows;
  if (!options_.participant) return flows;
  auto gateway = dds::Gateway::create(options_.participant, parts_->wake_word[0]);
  if (!gateway) return gateway.problems();
  auto opened = FlowManager::open(std::move(*gateway), parts_->wake_word.memory(), parts_->wiring,
                                  parts_->cell, parts_->of_device().name);
  if (!opened) return opened.problems();
  flows = std::move(*opened);
  return flows;
}

void DevicePlatform::wake(std::uint32_t bits) {
  std::atomic<std::uint32_t>& rings = parts_->wake_word[0].rings;
  rings.fetch_add(1, std::memory_order_seq_cst);
  os::futex_wake(rings, bits);
}

std::optional<Nanoseconds> DevicePlatform::ran_if_ready(std::int32_t thread) const {
  const auto use = os::read_thread_use(thread);
  return use && use->ready ? use->ran : std::nullopt;
}

void DevicePlatform::step(Instant now) {
  flight_->step(now);
  for (const std::string& text : flight_->messages()) log("", text);
  for (HostProcess* host : hosts_) host->step(parts_->of_device().name);
  for (ProgramProcess* program : programs_) program->step(parts_->of_device().name);
}

std::vector<Detection> DevicePlatform::detections() {
  std::vector<Detection> detections;
  check_gaps(detections);
  if (!violations_) return detections;
  for (const std::string& text : violations_->limitations())
    detections.push_back({.module = {}, .text = "warning: " + text});
  for (const SeenViolation& violation : violations_->news(parts_->paths)) {
    const std::string sentence = sentence_of(violation);
    if ((violation.module & channel::kOfExecutor) != 0) {
      const auto& executor = parts_->of_device().executors.at(violation.module & ~channel::kOfExecutor);
      detections.push_back(
          {.module = {}, .text = "WARNING: executor " + executor.name + " is not real-time: " + sentence});
    } else {
      detections.push_back({.module = violation.module,
                            .text = "WARNING: " + violation.hook + " is not real-time: " + sentence,
                            .cause = violation.hook + ": " + sentence});
    }
  }
  return detections;
}

// Detects that the kernel kept an executor from its CPU. In this case, the executor's next row starts late,
// by about the time for which the kernel throttles. The kernel's own report does not suffice: it appears only
// once, only up to Linux 6.11, and does not name the thread.
void DevicePlatform::check_gaps(std::vector<Detection>& detections) {
  while (const auto text = kernel_news_.next()) {
    if (text->find("RT throttling activated") != std::string::npos)
      detections.push_back({.module = {}, .text = "warning: the kernel reports: " + *text});
  }
  if (!throttling_ || !parts_->real_time) return;
  for (std::size_t e = 0; e < parts_->channel.executors(); ++e) {
    const std::int64_t latest = parts_->channel.executor(e).latest_ns.load(std::memory_order_relaxed);
    if (latest == seen_latest_ns_[e] || throttled_[e]) continue;
    seen_latest_ns_[e] = latest;
    if (const auto text = throttled(parts_->of_device().executors[e], Nanoseconds{latest}, *throttling_)) {
      throttled_[e] = true;
      detections.push_back({.module = {}, .text = "warning: " + *text});
    }
  }
}

void DevicePlatform::forget(std::uint32_t) {
  if (retained_) retained_->update();
}

std::optional<Result<void>> DevicePlatform::forgotten(std::uint32_t module) {
  return retained_ ? retained_->updated(parts_->saved_of(module)) : Result<void>{};
}

bool DevicePlatform::finish() {
  const bool recorded = !flight_ || flight_->finish();
  const bool retained = !retained_ || retained_->finish();
  return recorded && retained;
}

// Returns one problem for each module and executor with real-time violations.
Problems DevicePlatform::final_problems() {
  Problems problems;
  if (!violations_) return problems;
  const model::Device& device = parts_->of_device();
  for (const auto& [module, count] : violations_->counts()) {
    const bool of_executor = (module & channel::kOfExecutor) != 0;
    const std::string name = of_executor ? "executor " + device.name + "." +
                                               device.executors.at(module & ~channel::kOfExecutor).name
                                         : "module " + device.name + "." + device.modules.at(module).name;
    problems.push_back({name,
                        "is not real-time: " + std::to_string(count) +
                            (count == 1 ? " violation" : " violations") + " of the rules of real-time code",
                        "the report lists each violation with the calls that led to it"});
  }
  return problems;
}

void DevicePlatform::add_to(nlohmann::ordered_json& report) const {
  if (violations_) report["realtime_violations"] = violations_->report(parts_->of_device());
}

void DevicePlatform::stepped(const supervision::Step& step) {
  flight_->changed({.time_ns = to_ns(os::now()),
                    .module = step.module,
                    .from = lifecycle::to_text(step.transition.from),
                    .to = lifecycle::to_text(step.transition.to),
                    .event = lifecycle::to_text(step.transition.event),
                    .text = step.text});
}

void DevicePlatform::fault(const std::string& why) { flight_->fault(why); }

void DevicePlatform::host_died(const model::HostShare& share) {
  for (const std::size_t e : share.executors) flight_->host_died(e);
}

void DevicePlatform::trace(Nanoseconds last, std::size_t most,
                           std::function<void(const Result<std::string>&)> done) {
  flight_->trace(last, most, std::move(done));
}

std::vector<const os::Fd*> DevicePlatform::wait_on() const {
  std::vector<const os::Fd*> fds;
  for (const HostProcess* host : hosts_) host->wait_on(fds);
  for (const ProgramProcess* program : programs_) program->wait_on(fds);
  return fds;
}

}  // namespace takt::node
