// The supervisor's part of the flight record: modules, ports and lifecycle steps.
#include <takt/node/supervisor.hpp>
#include <takt/os/clock.hpp>

namespace takt::node {

Result<void> Supervisor::start_record() {
  FlightRecorder::Options options{.cell = options_.cell.name,
                                  .device = device().name,
                                  .modules = {},
                                  .executors = {},
                                  .files = options_.traces};
  for (const model::Executor& executor : device().executors) options.executors.push_back(executor.name);
  for (std::size_t m = 0; m < device().modules.size(); ++m) {
    const model::Module& module = device().modules[m];
    options.modules.push_back({.name = module.name,
                               .process = module.type == model::ModuleType::process,
                               .budget = module.budget.value_or(Nanoseconds{0})});
    if (!options_.ports[m]) continue;
    for (const model::Port& port : *options_.ports[m]) options.modules.back().ports.push_back(port.name);
  }
  auto recorder = FlightRecorder::create(std::move(options), plan_, channel_);
  if (!recorder) return recorder.problems();
  flight_ = std::move(*recorder);
  return {};
}

void Supervisor::record(const Member& member, const lifecycle::Transition& step, const std::string& text) {
  flight_->changed({.time_ns = to_ns(os::now()),
                    .module = member.index,
                    .from = lifecycle::to_text(step.from),
                    .to = lifecycle::to_text(step.to),
                    .event = lifecycle::to_text(step.event),
                    .text = text});
  if (step.event == lifecycle::Event::error && phase_ == Phase::running)
    flight_->fault("module " + member.model.name + ": " + text);
}

void Supervisor::trace(Nanoseconds last, std::size_t most,
                       std::function<void(const Result<std::string>&)> done) {
  flight_->trace(last, most, std::move(done));
}

}  // namespace takt::node
