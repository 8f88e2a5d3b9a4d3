#include "table1_page.hpp"

#include <fmt/format.h>

#include "drawing/canvas.hpp"
#include "jitter_chart.hpp"
#include "surroundings.hpp"

namespace takt::bench {

namespace {

using tool::escaped;

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; }
body { font: 14px/1.45 system-ui, sans-serif; max-width: 1200px; margin: 2em auto; padding: 0 1em; color: #1f2933; background: #ffffff; }
table { border-collapse: collapse; margin: 1em 0; }
p { max-width: 1000px; }
th, td { padding: 2px 6px; text-align: right; border-bottom: 1px solid #dde3e9; white-space: nowrap; }
th { font-weight: 600; }
.left, .facts td, .facts th { text-align: left; white-space: normal; }
.first td { border-top: 2px solid #c3ccd5; }
.held { color: #1a7f37; font-weight: 600; }
.more, .not { color: #9a4a00; font-weight: 600; }
.soft { color: #5c6773; }
.left.whose { white-space: nowrap; }
a { color: #1d5fa8; }
.wide { overflow-x: auto; }
@media print { table { font-size: 9px; } th, td { padding: 1px 3px; } .wide { overflow: visible; } }
svg { max-width: 100%; height: auto; }
)";
constexpr const char* kDarkStyle = R"(
body { color: #e4e9ee; background: #14181d; }
th, td { border-color: #2c343d; }
.first td { border-color: #3d4854; }
.held { color: #6fcf8a; }
.more, .not { color: #f0b060; }
.soft { color: #9aa6b2; }
a { color: #7db4f0; }
)";

const char* class_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::held:
      return "held";
    case Verdict::more_modules:
      return "more";
    case Verdict::not_held:
      return "not";
  }
  return "";
}

std::string modules_text(const Table1Case& one) {
  std::string text;
  const auto add = [&text](int count, const char* what) {
    if (count != 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
  };
  add(one.so, "periodic .so");
  add(one.exe, "periodic .exe");
  add(one.sporadic_so, "sporadic .so");
  add(one.sporadic_exe, "sporadic .exe");
  add(one.non_real, "non-real-time");
  return text;
}

std::string facts(const Table1Result& result) {
  std::string rows;
  const auto row = [&rows](const std::string& what, const std::string& how) {
    rows += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", escaped(what), escaped(how));
  };
  row("date", date_text(result.wall_ns));
  for (const auto& [what, how] : described(result.machine)) row(what, how);
  row("background", result.load.empty() ? "none started by the benchmark" : result.load);
  return "<table class=\"facts\">\n" + rows + "</table>\n";
}

std::string row_of(const char* whose, const Distribution& d, std::uint64_t missed) {
  return fmt::format(
      "<td "
      "class=\"left "
      "whose\">{}</td><td>{}</td><td>{:.6g}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</"
      "td>",
      whose, in_us(d.mean), d.variance / 1e6, in_us(d.max), in_us(d.p50), in_us(d.p99), in_us(d.p999),
      missed);
}

std::string rows_of(const CaseResult& one, const Table1Result& result) {
  const Judgement judgement = judge(one, result.period, result.cpus);
  const Table1Case& c = one.one;
  return fmt::format(
      R"(<tr class="first"><td rowspan="3"><a href="#case{0}">{0}</a></td><td rowspan="3">{1}</td><td rowspan="3">{2}</td><td rowspan="3">{3}</td><td rowspan="3">{4}</td><td rowspan="3">{5}</td><td rowspan="3">{6}</td>{7}<td rowspan="3">{8:.0f}</td><td rowspan="3" class="left {9}">{10}</td></tr>
<tr class="soft"><td class="left whose">paper</td><td>{11:g}</td><td>{12:g}</td><td>{13:g}</td><td colspan="4"></td></tr>
<tr class="soft">{14}</tr>
)",
      c.number, c.so, c.exe, c.sporadic_so, c.sporadic_exe, c.non_real, model::to_text(c.measured),
      row_of("takt", one.takt, one.missed), static_cast<double>(one.stolen.count()) / 1e6,
      class_of(judgement.verdict), to_text(judgement.verdict), c.paper.mean, c.paper.variance, c.paper.worst,
      row_of("bare loop", one.loop, one.loop_missed));
}

std::string table(const Table1Result& result) {
  std::string text =
      R"(<div class="wide"><table>
<tr><th rowspan="2">no</th><th colspan="2">periodic</th><th colspan="2">sporadic</th><th rowspan="2">non-real</th><th rowspan="2">measured</th><th rowspan="2"></th><th colspan="6">jitter, us (variance: us<sup>2</sup>)</th><th rowspan="2">missed</th><th rowspan="2">stolen, ms</th><th rowspan="2" class="left">verdict</th></tr>
<tr><th>.so</th><th>.exe</th><th>.so</th><th>.exe</th><th>mean</th><th>variance</th><th>worst</th><th>p50</th><th>p99</th><th>p99.9</th></tr>
)";
  for (const CaseResult& one : result.cases) text += rows_of(one, result);
  return text + "</table></div>\n";
}

std::string section(const CaseResult& one, const Table1Result& result) {
  const Judgement judgement = judge(one, result.period, result.cpus);
  const int number = one.one.number;
  const char* const type = model::to_text(one.one.measured);
  return fmt::format(
             "<h2 id=\"case{0}\">Case {0}</h2>\n<p>{1}; measured in a {2} module. <span "
             "class=\"{3}\">{4}</span>{5}{6}</p>\n",
             number, modules_text(one.one), type, class_of(judgement.verdict), to_text(judgement.verdict),
             judgement.why.empty() ? "" : ": ", escaped(judgement.why)) +
         jitter_over_time(fmt::format("Case {}: absolute jitter over time (range and median)", number),
                          one.jitter, result.period) +
         jitter_histogram(fmt::format("Case {}: distribution of the releases by absolute jitter", number),
                          one.jitter, one.bare);
}

}  // namespace

std::string table1_page(const Table1Result& result) {
  std::string page =
      fmt::format(R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8"/>
<title>Takt: {0}</title>
<style>{1}{2}@media (prefers-color-scheme: dark) {{{3}}}
</style>
</head>
<body>
<h1>Takt, Table 1</h1>
<p>{0}.</p>
{4}{5}<p class="soft">Jitter is release minus start, Eq. (1) of the paper. Mean and variance are signed, the others are of the
absolute value. The bare loop is a thread with clock_nanosleep() on the same CPU at the same priority; half of it runs before
each case and half after. Missed: whole periods that passed without a start. Stolen: CPU time that other machines on the same
hardware took during the case. Held, for a thread module: p50 is at most 0.1 us, and p99 is at most half of the bare loop's;
from a period of 1 ms on, p99 is also at most 1 us. Held, for a process module: p50 is at most 1 us. A case needs one CPU for
the executor and one for each real-time program.</p>
)",
                  escaped(title_of(result)), tool::page_colours(kChartColours, kDarkChartColours), kStyle,
                  kDarkStyle, facts(result), table(result));
  for (const CaseResult& one : result.cases) page += section(one, result);
  return page + "</body>\n</html>\n";
}

}  // namespace takt::bench
