// The device's object of the status JSON.
#include <algorithm>

#include <nlohmann/json.hpp>

#include <takt/node/supervisor.hpp>

namespace takt::node {

namespace {

using json = nlohmann::ordered_json;

json in_microseconds(const StatisticsSnapshot& s) {
  const auto us = [](auto ns) { return static_cast<double>(ns) / 1e3; };
  return {{"mean", us(s.mean)},
          {"variance", s.variance / 1e6},
          {"min", us(s.min)},
          {"p50", us(s.quantile(0.5))},
          {"p99", us(s.quantile(0.99))},
          {"p999", us(s.quantile(0.999))},
          {"max", us(s.max)}};
}

}  // namespace

json Supervisor::report() const {
  constexpr auto relaxed = std::memory_order_relaxed;
  json executors = json::array();
  for (std::size_t e = 0; e < channel_.executors(); ++e) {
    const channel::ExecutorBlock& block = channel_.executor(e);
    executors.push_back({{"name", device().executors[e].name},
                         {"cycles", block.cycles.load(relaxed)},
                         {"missed", block.missed.load(relaxed)},
                         {"jitter_us", in_microseconds(block.jitter.read())}});
  }
  json modules = json::array();
  for (const auto& member : members_) {
    const channel::ModuleBlock& block = member->block;
    const Statistics& jitter = member->seat == nullptr ? block.jitter : member->seat->jitter;
    const Statistics& run = member->seat == nullptr ? block.run : member->seat->run;
    modules.push_back({{"name", member->model.name},
                       {"type", model::to_text(member->model.type)},
                       {"operation", model::to_text(member->model.operation)},
                       {"state", lifecycle::to_text(member->state())},
                       {"cycles", block.cycles.load(relaxed)},
                       {"overruns", block.overruns.load(relaxed) +
                                        (member->seat == nullptr ? 0 : member->seat->late.load(relaxed))},
                       {"errors", block.errors.load(relaxed) + member->errors},
                       {"jitter_us", in_microseconds(jitter.read())},
                       {"run_us", in_microseconds(run.read())},
                       {"pid", member->is_thread() ? host_.pid() : member->last_pid}});
  }
  return {{"name", device().name},
          {"alive", true},
          {"real_time", real_time_},
          {"executors", executors},
          {"modules", modules}};
}

}  // namespace takt::node
