#include "reports/trace_report.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/page.hpp"

namespace takt::tool {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kWorst = 10;
constexpr const char* kFormat = "takt trace 1";
/// The causes of a late start, in the order in which Takt checks them.
constexpr std::array<const char*, 7> kCauses{"own overrun", "predecessor", "wake-up", "preemption",
                                             "page fault",  "hypervisor",  "unknown"};

std::string time_text(double us) {
  if (us < 1e3) return fmt::format("{:.1f} us", us);
  if (us < 1e6) return fmt::format("{:.2f} ms", us / 1e3);
  return fmt::format("{:.3f} s", us / 1e6);
}

std::string utc(std::int64_t ns) {
  const std::time_t second = ns / 1'000'000'000;
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(second));
}

/// The quantile `q` of sorted values.
double quantile(const std::vector<double>& values, double q) {
  const auto place = static_cast<std::size_t>(q * static_cast<double>(values.size()));
  return values[std::min(place, values.size() - 1)];
}

struct OfCause {
  std::string cause;
  std::vector<double> late_us;  // sorted
};

std::vector<OfCause> by_cause(const TraceSummary& summary) {
  std::vector<OfCause> all;
  for (const char* cause : kCauses) {
    OfCause of{cause, {}};
    for (const TracedStart& start : summary.late) {
      if (start.cause == cause) of.late_us.push_back(start.late_us);
    }
    std::sort(of.late_us.begin(), of.late_us.end());
    if (!of.late_us.empty()) all.push_back(std::move(of));
  }
  return all;
}

}  // namespace

Result<TraceSummary> summary_of(const Json& trace) {
  const auto rejected = [](const std::string& what) {
    return fail(what, "give a file that takt trace or a node wrote");
  };
  const bool is_trace = trace.is_object() && trace.contains("otherData") && trace["otherData"].is_object() &&
                        trace["otherData"].contains("format") && trace["otherData"]["format"] == kFormat;
  if (!is_trace) return rejected("is not a Takt trace");
  TraceSummary summary;
  try {
    const Json& about = trace.at("otherData");
    summary.cell = about.at("cell");
    summary.device = about.at("device");
    summary.machine = about.at("machine");
    summary.kernel = about.at("kernel");
    summary.why = about.at("why");
    summary.taken_utc_ns = about.at("taken_utc_ns");
    summary.lasts_us = about.at("lasts_us");
    summary.left_out_us = about.value("left_out_us", 0.0);
    summary.lost = about.at("lost");
    std::map<std::uint64_t, std::string> names;
    for (const Json& thread : about.at("threads")) {
      names[thread.at("thread")] = thread.at("executor");
      if (!thread.contains("basic_period_us")) continue;
      summary.executors.push_back({.name = thread.at("executor"),
                                   .rows = thread.at("rows"),
                                   .late = thread.at("late"),
                                   .lost = thread.at("lost"),
                                   .holds_us = thread.value("holds_us", 0.0),
                                   .late_beyond_us = thread.at("late_beyond_us")});
    }
    for (const Json& event : trace.at("traceEvents")) {
      const std::string kind = event.value("cat", "");
      if (kind == "state") ++summary.changes[event.at("name")];
      if ((kind != "row" && kind != "run") || !event.contains("args") || !event["args"].contains("cause"))
        continue;
      const Json& details = event["args"];
      const std::string executor = names[event.at("tid")];
      summary.late.push_back(
          {.what = kind == "row" ? executor : executor + "." + event.at("name").get<std::string>(),
           .at_us = details.at("due_us"),
           .late_us = details.at("begins_late_us"),
           .cause = details.at("cause"),
           .why = details.at("why")});
    }
  } catch (const Json::exception& exception) {
    return rejected(std::string{"is an incomplete Takt trace: "} + exception.what());
  }
  std::stable_sort(summary.late.begin(), summary.late.end(),
                   [](const TracedStart& a, const TracedStart& b) { return a.late_us > b.late_us; });
  return summary;
}

std::string trace_report(const TraceSummary& s, const Style& style) {
  Page page{style};
  page.heading(0, s.cell + "." + s.device,
               fmt::format("{} until {}, on {}", time_text(s.lasts_us), utc(s.taken_utc_ns), s.machine));
  page.sentence(2, "Taken: " + s.why);
  if (s.left_out_us > 0)
    page.sentence(2, fmt::format("The {} before this trace did not fit into the file and were left out.",
                                 time_text(s.left_out_us)));
  if (s.lost != 0)
    page.sentence(2,
                  page.warning(fmt::format("{} entries were overwritten while the trace was read.", s.lost)));
  page.blank();
  std::vector<Page::Words> rows{{"executor", "rows", "late starts", "late from", "recorded", "lost"}};
  for (const TracedExecutor& e : s.executors) {
    rows.push_back({e.name, std::to_string(e.rows), std::to_string(e.late), time_text(e.late_beyond_us),
                    time_text(e.holds_us), std::to_string(e.lost)});
  }
  page.table(0, rows);
  if (s.late.empty()) {
    page.blank();
    page.line(0, "No row and no module began late.");
    return std::move(page).take();
  }
  page.blank();
  rows = {{"cause", "late starts", "p50", "p99", "max"}};
  for (const OfCause& of : by_cause(s)) {
    rows.push_back({of.cause, std::to_string(of.late_us.size()), time_text(quantile(of.late_us, 0.5)),
                    time_text(quantile(of.late_us, 0.99)), time_text(of.late_us.back())});
  }
  page.table(0, rows);
  page.blank();
  page.line(
      0, s.late.size() > kWorst ? fmt::format("The worst {} of {}:", kWorst, s.late.size()) : "All of them:");
  for (std::size_t i = 0; i < std::min(kWorst, s.late.size()); ++i) {
    const TracedStart& start = s.late[i];
    page.sentence(2, fmt::format("{} late: {}, due at {}", time_text(start.late_us), start.what,
                                 time_text(start.at_us)));
    page.sentence(4, start.cause + ": " + start.why);
  }
  return std::move(page).take();
}

Json trace_json_report(const TraceSummary& s) {
  Json executors = Json::array();
  for (const TracedExecutor& e : s.executors) {
    executors.push_back({{"name", e.name},
                         {"rows", e.rows},
                         {"late", e.late},
                         {"late_beyond_us", e.late_beyond_us},
                         {"holds_us", e.holds_us},
                         {"lost", e.lost}});
  }
  Json causes = Json::object();
  for (const OfCause& of : by_cause(s)) {
    causes[of.cause] = {{"count", of.late_us.size()},
                        {"p50_us", quantile(of.late_us, 0.5)},
                        {"p99_us", quantile(of.late_us, 0.99)},
                        {"max_us", of.late_us.back()}};
  }
  Json worst = Json::array();
  for (std::size_t i = 0; i < std::min(kWorst, s.late.size()); ++i) {
    const TracedStart& start = s.late[i];
    worst.push_back({{"what", start.what},
                     {"due_us", start.at_us},
                     {"late_us", start.late_us},
                     {"cause", start.cause},
                     {"why", start.why}});
  }
  return {{"cell", s.cell},         {"device", s.device},
          {"machine", s.machine},   {"kernel", s.kernel},
          {"why", s.why},           {"taken_utc_ns", s.taken_utc_ns},
          {"lasts_us", s.lasts_us}, {"lost", s.lost},
          {"executors", executors}, {"late_starts", s.late.size()},
          {"causes", causes},       {"worst", worst}};
}

}  // namespace takt::tool
