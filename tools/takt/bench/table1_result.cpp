#include "table1_result.hpp"

#include <fmt/format.h>

#include "surroundings.hpp"

namespace takt::bench {

namespace {

constexpr double kThreadP50 = 100;    // ns
constexpr double kThreadP99 = 1'000;  // ns; limit of p99 for periods of kSlow and longer
constexpr double kOfBareP99 = 0.5;
constexpr double kProcessP50 = 1'000;  // ns
constexpr Nanoseconds kSlow = std::chrono::milliseconds{1};

std::string beyond(const char* what, double value, double most, const char* which = "") {
  return fmt::format("{} {} us is more than {} us{}", what, in_us(value), in_us(most), which);
}

std::string shortfall(const CaseResult& result, Nanoseconds period) {
  if (result.takt.count == 0) return "no release was recorded";
  if (!result.real_time) return "the system denied real-time scheduling";
  if (!result.loop_real_time) return "the system denied the bare loop its priority or CPU";
  std::vector<std::string> reasons;
  if (result.one.measured == model::ModuleType::process) {
    if (result.takt.p50 > kProcessP50) reasons.push_back(beyond("p50", result.takt.p50, kProcessP50));
  } else {
    if (result.takt.p50 > kThreadP50) reasons.push_back(beyond("p50", result.takt.p50, kThreadP50));
    if (result.takt.p99 > kOfBareP99 * result.loop.p99)
      reasons.push_back(
          beyond("p99", result.takt.p99, kOfBareP99 * result.loop.p99, ", half the bare loop's"));
    if (period >= kSlow && result.takt.p99 > kThreadP99)
      reasons.push_back(beyond("p99", result.takt.p99, kThreadP99));
  }
  return fmt::format("{}", fmt::join(reasons, "; "));
}

}  // namespace

Judgement judge(const CaseResult& result, Nanoseconds period, int cpus) {
  std::string why = shortfall(result, period);
  if (why.empty()) return {};
  const int wanted = result.one.cpus_wanted();
  if (cpus < wanted) {
    return {Verdict::more_modules,
            fmt::format("{}; the case needs {} CPUs and the machine has {}", why, wanted, cpus)};
  }
  return {Verdict::not_held, why};
}

const char* to_text(Verdict verdict) {
  switch (verdict) {
    case Verdict::held:
      return "held";
    case Verdict::more_modules:
      return "more modules than cores";
    case Verdict::not_held:
      return "not held";
  }
  return "";
}

std::string title_of(const Table1Result& result) {
  return fmt::format("Table 1 at a basic period of {}, {:g} s per case, on CPU {} at priority {}{}",
                     takt::to_text(result.period), result.seconds, result.cpu, result.priority,
                     result.load.empty() ? "" : ", with background load: " + result.load);
}

}  // namespace takt::bench
