// Compares the analysis with a simulation. For each random device that the analysis accepts, the test
// simulates many combinations of start times, with long and short runs. In no simulation may a module miss a
// deadline.
#include <takt/schedule/analysis.hpp>

#include <gtest/gtest.h>
#include <full_form.hpp>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <sstream>
#include <string>

#include "simulated_device.hpp"

namespace takt::schedule::analysis_against_simulation_test {
namespace {

using model::Device;
using model::Module;
using model::ModuleType;
using model::Operation;
using simulated::Phasing;
using simulated::Random;
using simulated::Tick;

constexpr int kBatches = 10;
constexpr int kDevicesOfABatch = 120;
constexpr Tick kLongest = 2500;

struct Drawn {
  model::Cell cell;
  std::vector<std::optional<Nanoseconds>> runs;
  std::vector<int> cpus;
  [[nodiscard]] const Device& device() const { return cell.devices.front(); }
};

class Draw {
 public:
  explicit Draw(Random& random) : random_(random) {}

  Drawn device() {
    Drawn drawn;
    drawn.cpus.resize(static_cast<std::size_t>(one_of({1, 2, 2, 3, 4})));
    std::iota(drawn.cpus.begin(), drawn.cpus.end(), 0);
    Device& device = drawn.cell.devices.emplace_back();
    const int executors = one_of({1, 1, 2, 2, 3});
    for (int e = 0; e < executors; ++e) device.executors.push_back(executor(e, drawn.cpus.size()));
    // The load of the device, from almost none to more than its CPUs can carry.
    const double fullness = std::uniform_real_distribution<>{0.05, 1.0}(random_);
    const double programs = one_of({1, 3, 8}) / 10.0;
    const int periodic = between(executors, executors + 4);
    for (int i = 0; i < periodic; ++i) {
      Module& module = add(device, i % executors);
      module.period = Nanoseconds{one_of({10, 12, 15, 20, 20, 24, 30, 40, 60})};
      if (chance(0.2)) module.offset = Nanoseconds{between(0, static_cast<int>(module.period->count()) - 1)};
      if (i >= executors && chance(programs)) module.type = ModuleType::process;
      drawn.runs.push_back(run(*module.period, fullness / 1.5));
    }
    const int sporadic = between(0, 3);
    for (int i = 0; i < sporadic; ++i) {
      Module& module = add(device, between(0, executors - 1));
      module.operation = Operation::sporadic;
      module.deadline = Nanoseconds{one_of({20, 30, 40, 60, 120, 200})};
      if (chance(programs)) module.type = ModuleType::process;
      if (chance(0.3)) module.dispatch = model::Dispatch::immediate;
      if (module.dispatch == model::Dispatch::immediate || chance(0.5))
        module.interarrival = Nanoseconds{one_of({15, 20, 50, 100})};
      drawn.runs.push_back(run(std::min<Nanoseconds>(*module.deadline, Nanoseconds{40}), fullness / 2));
    }
    return drawn;
  }

 private:
  int between(int least, int most) { return std::uniform_int_distribution<>{least, most}(random_); }
  bool chance(double share) { return std::bernoulli_distribution{share}(random_); }
  int one_of(const std::vector<int>& choices) {
    return choices[static_cast<std::size_t>(between(0, static_cast<int>(choices.size()) - 1))];
  }
  Nanoseconds run(Nanoseconds period, double share) {
    const int most = static_cast<int>(static_cast<double>(period.count()) * share);
    return Nanoseconds{between(1, std::max(1, most))};
  }
  model::Executor executor(int index, std::size_t cpus) {
    model::Executor executor;
    executor.name = "e" + std::to_string(index);
    if (chance(0.3)) executor.cpu = between(0, static_cast<int>(cpus) - 1);
    // The executors have similar priorities. So some programs and sporadic threads of one executor have
    // priorities between the priorities of two other executors.
    executor.priority = one_of({2, 3, 9, 10, 11, 12, 13, 20});
    executor.wakeup = chance(0.5)   ? model::Wakeup::sleep
                      : chance(0.9) ? model::Wakeup::hybrid
                                    : model::Wakeup::spin;
    executor.rate_monotonic = chance(0.1);
    if (chance(0.2)) executor.offsets = model::Offsets::automatic;
    executor.spin_share = one_of({1, 2, 4}) / 10.0;
    return executor;
  }
  Module& add(Device& device, int executor) {
    Module& module = device.modules.emplace_back();
    module.name = "m" + std::to_string(device.modules.size() - 1);
    module.executor = device.executors[static_cast<std::size_t>(executor)].name;
    // Some modules have equal priorities, so that their programs share a level.
    module.priority = static_cast<int>(device.modules.size()) / (chance(0.5) ? 1 : 2);
    return module;
  }

  Random& random_;
};

std::string described(const Drawn& drawn, const std::vector<WorstCase>& worst) {
  std::ostringstream text;
  text << drawn.cpus.size() << " CPUs\n";
  for (const model::Executor& e : drawn.device().executors) {
    text << "  " << e.name << " cpu " << (e.cpu ? std::to_string(*e.cpu) : "any") << " priority "
         << e.priority << " " << to_text(e.wakeup) << " " << e.spin_share << "\n";
  }
  for (const WorstCase& one : worst) {
    const Module& m = drawn.device().modules[one.module];
    text << "  " << m.name << " on " << m.executor << ", " << to_text(m.type) << " " << to_text(m.operation)
         << " " << to_text(m.dispatch) << ", every or by " << one.deadline.count() << ", interarrival "
         << m.interarrival.value_or(Nanoseconds{}).count() << ", runs " << one.run.count() << ", response "
         << (one.response ? std::to_string(one.response->count()) : "none") << " " << one.why << "\n";
  }
  return text.str();
}

Tick length_of(const DevicePlan& plan) {
  Tick common = 1;
  for (const ExecutorPlan& executor : plan.executors) {
    if (executor.rows() != 0) common = std::lcm(common, executor.macro_period.count());
  }
  return std::min(3 * common + 300, kLongest);
}

/// Returns the phasings to simulate. In some, all worst cases coincide; in others, runs and spins are
/// shorter, or sporadic modules are released later or less often.
std::vector<Phasing> phasings(Random& random) {
  std::vector<Phasing> all{{}, {.spin = 0}, {.longest = 0.9}, {.longest = 0.5, .spin = 0.5}};
  for (const double ready : {0.02, 0.1, 0.5}) {
    for (const double longest : {1.0, 0.8})
      all.push_back({.longest = longest, .ready = ready, .spin = longest});
  }
  for (int i = 0; i < 10; ++i)
    all.push_back({.sporadic_from = std::uniform_int_distribution<Tick>{1, 130}(random)});
  return all;
}

class AnalysisAgainstSimulation : public testing::TestWithParam<int> {};

TEST_P(AnalysisAgainstSimulation, NeverAcceptsADeviceThatMissesADeadline) {
  if (GetParam() >= std::max(1, how_often(kBatches))) GTEST_SKIP() << "in the full form only";
  Random random{static_cast<Random::result_type>(GetParam())};
  int accepted = 0;
  int rejected = 0;
  int needlessly = 0;
  double tightness = 0;
  for (int n = 0; n < kDevicesOfABatch; ++n) {
    const Drawn drawn = Draw{random}.device();
    const Device& device = drawn.device();
    const DevicePlan device_plan = plan(drawn.cell, device).value();
    const Placement placement = place(device, model::Cpus::all(drawn.cpus));
    const auto worst = worst_cases(device, device_plan, placement, drawn.runs);
    const bool holds =
        std::all_of(worst.begin(), worst.end(), [](const WorstCase& one) { return one.kept(); });

    bool misses = false;
    std::vector<Tick> longest(device.modules.size());
    for (const Phasing& phasing : phasings(random)) {
      simulated::Machine machine{device, device_plan, placement, drawn.runs, phasing, random};
      const auto outcome = machine.run(length_of(device_plan), true);
      misses |= outcome.any_missed();
      for (std::size_t i = 0; i < longest.size(); ++i)
        longest[i] = std::max(longest[i], outcome.response[i].value_or(0));
      if (misses) break;
    }
    (holds ? accepted : rejected) += 1;
    needlessly += !holds && !misses;
    if (!holds) continue;
    ASSERT_FALSE(misses) << described(drawn, worst);
    double sum = 0;
    for (const WorstCase& one : worst) {
      ASSERT_LE(longest[one.module], one.response->count()) << "m" << one.module << " of\n"
                                                            << described(drawn, worst);
      sum += static_cast<double>(longest[one.module]) / static_cast<double>(one.response->count());
    }
    tightness += sum / static_cast<double>(worst.size());
  }
  std::printf(
      "%d accepted, %d rejected, of which %d never missed; the longest response is %.0f %% of the bound\n",
      accepted, rejected, needlessly, 100 * tightness / std::max(accepted, 1));
  EXPECT_GT(accepted, kDevicesOfABatch / 10) << "too few accepted devices to test anything";
  EXPECT_GT(rejected, kDevicesOfABatch / 10);
  EXPECT_LT(needlessly, kDevicesOfABatch / 4) << "the analysis is too pessimistic to be useful";
}

INSTANTIATE_TEST_SUITE_P(Batch, AnalysisAgainstSimulation, testing::Range(0, kBatches));

}  // namespace
}  // namespace takt::schedule::analysis_against_simulation_test
