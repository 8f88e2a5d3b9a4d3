#include "table1_report.hpp"

#include <fmt/format.h>

#include "surroundings.hpp"

namespace takt::bench {

namespace {

using json = nlohmann::ordered_json;

constexpr const char* kRow = "{:>2} {:>3} {:>3} {:>4} {:>5} {:>4} {:<8} {:<5} {:>8} {:>9} {:>8}";
constexpr const char* kNumbers = " {:>7} {:>7} {:>7} {:>7} {:>7}";

std::string variance_text(double ns2) { return fmt::format("{:.6g}", ns2 / 1e6); }

json in_json(const Distribution& d) {
  return {{"count", d.count},   {"mean", d.mean / 1e3}, {"variance", d.variance / 1e6},
          {"min", d.min / 1e3}, {"p50", d.p50 / 1e3},   {"p90", d.p90 / 1e3},
          {"p99", d.p99 / 1e3}, {"p999", d.p999 / 1e3}, {"max", d.max / 1e3}};
}

double in_ms(Nanoseconds time) { return static_cast<double>(time.count()) / 1e6; }

}  // namespace

std::string table1_head(const Table1Result& result) {
  return machine_text(result.machine) + "\n" + title_of(result) + "\n\n" +
         fmt::format(fmt::runtime(kRow), "no", ".so", "exe", "s.so", "s.exe", "n-rt", "measured", "", "mean",
                     "variance", "worst") +
         fmt::format(fmt::runtime(kNumbers), "p50", "p99", "p99.9", "missed", "stolen") + "\n";
}

std::string table1_rows(const CaseResult& one, const Table1Result& result) {
  const Table1Case& c = one.one;
  const auto numbers = [](const Distribution& d, std::uint64_t missed, const std::string& stolen) {
    return fmt::format(fmt::runtime(kNumbers), in_us(d.p50), in_us(d.p99), in_us(d.p999), missed, stolen) +
           "\n";
  };
  const auto row = [](const char* whose, const std::string& mean, const std::string& variance,
                      const std::string& worst) {
    return fmt::format(fmt::runtime(kRow), "", "", "", "", "", "", "", whose, mean, variance, worst);
  };
  std::string text = fmt::format(fmt::runtime(kRow), c.number, c.so, c.exe, c.sporadic_so, c.sporadic_exe,
                                 c.non_real, model::to_text(c.measured), "takt", in_us(one.takt.mean),
                                 variance_text(one.takt.variance), in_us(one.takt.max)) +
                     numbers(one.takt, one.missed, fmt::format("{:.0f}", in_ms(one.stolen)));
  text += row("paper", fmt::format("{:g}", c.paper.mean), fmt::format("{:g}", c.paper.variance),
              fmt::format("{:g}", c.paper.worst)) +
          "\n";
  text += row("bare", in_us(one.loop.mean), variance_text(one.loop.variance), in_us(one.loop.max)) +
          numbers(one.loop, one.loop_missed, "");
  const Judgement judgement = judge(one, result.period, result.cpus);
  text += fmt::format("   {}{}{}\n", to_text(judgement.verdict), judgement.why.empty() ? "" : ": ",
                      judgement.why);
  return text;
}

std::string table1_foot() {
  return "\n  Times are in us, variance in us^2. Jitter is release minus start, Eq. (1). Mean and variance\n"
         "  are computed from the signed values, the others from the absolute values. s.so, s.exe:\n"
         "  sporadic; n-rt: non-real-time. bare: a thread that waits with clock_nanosleep() on the same\n"
         "  CPU, at the same priority; half of it runs before the case, half after. missed: whole periods\n"
         "  that passed without a start. stolen: CPU time in ms that other virtual machines took during\n"
         "  the case.\n";
}

json table1_json(const Table1Result& result) {
  json cases = json::array();
  for (const CaseResult& one : result.cases) {
    const Table1Case& c = one.one;
    const Judgement judgement = judge(one, result.period, result.cpus);
    cases.push_back(
        {{"case", c.number},
         {"modules",
          {{"so", c.so},
           {"exe", c.exe},
           {"sporadic_so", c.sporadic_so},
           {"sporadic_exe", c.sporadic_exe},
           {"non_real", c.non_real}}},
         {"measured", model::to_text(c.measured)},
         {"jitter_us", in_json(one.takt)},
         {"paper_us", {{"mean", c.paper.mean}, {"variance", c.paper.variance}, {"worst", c.paper.worst}}},
         {"bare_us", in_json(one.loop)},
         {"cycles", one.cycles},
         {"missed", one.missed},
         {"bare_missed", one.loop_missed},
         {"stolen_ms", in_ms(one.stolen)},
         {"real_time", one.real_time},
         {"bare_real_time", one.loop_real_time},
         {"verdict", to_text(judgement.verdict)},
         {"why", judgement.why}});
  }
  return {{"benchmark", "table1"},
          {"date", date_text(result.wall_ns)},
          {"machine", machine_json(result.machine)},
          {"period_us", static_cast<double>(result.period.count()) / 1e3},
          {"seconds", result.seconds},
          {"processor", result.cpu},
          {"priority", result.priority},
          {"processors", result.cpus},
          {"load", result.load},
          {"cases", cases}};
}

}  // namespace takt::bench
