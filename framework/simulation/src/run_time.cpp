#include "run_time.hpp"

#include <algorithm>

namespace takt::simulation {

namespace {

/// The assumed run time of a module without a profile and budget is its period or deadline divided by kShare.
constexpr int kShare = 20;
constexpr Nanoseconds kLongestUsualRun = std::chrono::milliseconds{1};

Nanoseconds between(Nanoseconds low, Nanoseconds high, double share) {
  return low + Nanoseconds{static_cast<std::int64_t>(share * static_cast<double>((high - low).count()))};
}

}  // namespace

RunTime::RunTime(const model::Cell& cell, const model::Device& device, const model::Module& module,
                 const model::Profile& profile) {
  const auto measured = profile.modules.find(device.name + "." + module.name);
  if (profile.cell == cell.name && measured != profile.modules.end() && measured->second.runs != 0) {
    times_ = measured->second;
    return;
  }
  if (module.budget) {
    const Nanoseconds budget = *module.budget;
    times_ = {.runs = 1,
              .min = budget / 3,
              .p50 = budget / 2,
              .p99 = budget * 8 / 10,
              .p999 = budget * 17 / 20,
              .max = budget * 9 / 10};
    return;
  }
  const Nanoseconds own = module.period ? *module.period : module.deadline.value_or(kLongestUsualRun);
  const Nanoseconds usual = std::max(std::min(own / kShare, kLongestUsualRun), Nanoseconds{1});
  times_ = {.runs = 1,
            .min = usual / 2,
            .p50 = usual,
            .p99 = usual * 3 / 2,
            .p999 = usual * 2,
            .max = usual * 5 / 2};
}

Nanoseconds RunTime::draw(Draws& draws) const {
  const double share = draws.share();
  if (share < 0.5) return between(times_.min, times_.p50, share / 0.5);
  if (share < 0.99) return between(times_.p50, times_.p99, (share - 0.5) / 0.49);
  if (share < 0.999) return between(times_.p99, times_.p999, (share - 0.99) / 0.009);
  return between(times_.p999, times_.max, (share - 0.999) / 0.001);
}

}  // namespace takt::simulation
