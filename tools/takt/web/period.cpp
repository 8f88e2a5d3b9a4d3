#include "web/period.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <takt/schedule/plan.hpp>

#include "web/samples_json.hpp"

namespace takt::tool::web {

namespace {

constexpr Nanoseconds kMostTrace = std::chrono::seconds{10};
constexpr double kNone = -1;

double in_us(Nanoseconds duration) { return static_cast<double>(duration.count()) / 1e3; }
std::int64_t in_ns(double us) { return std::llround(us * 1e3); }

/// The thread ids in a trace, as the trace gives them.
struct Threads {
  std::map<std::string, double> rows;      // for each executor, the thread that runs its rows
  std::map<std::string, double> sporadic;  // for each executor, the thread that runs its sporadic modules
};

Threads threads_of(const Json& about) {
  Threads threads;
  for (const Json& thread : about.at("threads")) {
    const auto executor = thread.at("executor").get<std::string>();
    (thread.contains("basic_period_us") ? threads.rows : threads.sporadic)[executor] =
        thread.at("thread").get<double>();
  }
  return threads;
}

struct Window {
  double from_us = 0;
  double to_us = 0;
  [[nodiscard]] bool holds(double us) const { return us >= from_us && us < to_us; }
};

Json run_json(const Json& event, const Window& window) {
  const double at = event.at("ts").get<double>();
  Json run{{"module", event.at("name")},
           {"begin_ns", in_ns(at - window.from_us)},
           {"end_ns", in_ns(at + event.at("dur").get<double>() - window.from_us)}};
  if (event.contains("args")) {
    const Json& args = event["args"];
    if (args.contains("begins_late_us")) run["late_ns"] = in_ns(args["begins_late_us"].get<double>());
    if (args.contains("why")) run["cause"] = args["why"];
  }
  return run;
}

bool is(const Json& event, const char* category, double thread) {
  return event.value("cat", "") == category && event.value("tid", kNone) == thread;
}

/// The rows in a time window. A trace lists the rows in the order in which they began, and the runs of a row
/// after that row.
Json rows_json(const Json& trace, double thread, const Window& window, double basic_us) {
  Json rows = Json::array();
  double row_end = 0;
  bool within = false;
  for (const Json& event : trace.at("traceEvents")) {
    if (is(event, "row", thread)) {
      const double release = event.at("args").at("release_us").get<double>();
      // Releases are multiples of the basic period, but the trace rounds them when it writes them as text.
      const double row = std::round((release - window.from_us) / basic_us);
      within = row >= 0 && release < window.to_us - basic_us / 2 && rows.size() < kMostRows;
      if (!within) continue;
      const double begin = event.at("ts").get<double>();
      row_end = begin + event.at("dur").get<double>();
      rows.push_back({{"row", static_cast<std::int64_t>(row)},
                      {"due_ns", in_ns(release - window.from_us)},
                      {"begin_ns", in_ns(begin - window.from_us)},
                      {"end_ns", in_ns(row_end - window.from_us)}});
      if (event["args"].contains("why")) rows.back()["cause"] = event["args"]["why"];
      rows.back()["runs"] = Json::array();
    } else if (within && is(event, "run", thread) && event.at("ts").get<double>() <= row_end) {
      rows.back()["runs"].push_back(run_json(event, window));
    }
  }
  return rows;
}

/// Adds each run of a sporadic module to the row in which the run began.
void add_sporadic(Json& rows, const Json& trace, double thread, const Window& window, double basic_us) {
  for (const Json& event : trace.at("traceEvents")) {
    if (!is(event, "run", thread)) continue;
    const double at = event.at("ts").get<double>();
    if (!window.holds(at)) continue;
    const auto row = static_cast<std::int64_t>((at - window.from_us) / basic_us);
    const auto place =
        std::find_if(rows.begin(), rows.end(), [row](const Json& r) { return r["row"] == row; });
    if (place == rows.end()) continue;
    (*place)["runs"].push_back(run_json(event, window));
    (*place)["runs"].back()["sporadic"] = true;
  }
}

}  // namespace

Nanoseconds trace_needed(const model::Cell& cell, const model::Device& device) {
  Nanoseconds longest{};
  if (const auto plan = schedule::plan(cell, device)) {
    for (const schedule::ExecutorPlan& executor : plan->executors)
      longest = std::max(longest, std::min(executor.macro_period, kMostTrace));
  }
  return std::min(2 * longest + std::chrono::milliseconds{50}, kMostTrace);
}

Result<Json> period_json(const Json& trace, const model::Cell& cell, const model::Device& device) {
  const auto plan = schedule::plan(cell, device);
  if (!plan) return plan.problems();
  try {
    const Json& about = trace.at("otherData");
    if (!about.contains("t0_us"))
      return fail("device " + device.name + " has not run a row of its table yet",
                  "try again when the device runs");
    const double t0 = about["t0_us"].get<double>();
    const double end = about.at("lasts_us").get<double>();
    const auto begins_ns = about.at("begins_utc_ns").get<std::int64_t>();
    const Threads threads = threads_of(about);
    Json executors = Json::array();
    Window longest{end, end};
    for (const schedule::ExecutorPlan& one : plan->executors) {
      if (one.periodic.empty() && one.sporadic.empty()) continue;
      const std::string& name = device.executors[one.executor].name;
      const double macro = in_us(one.macro_period);
      const double basic = in_us(one.basic_period);
      const double periods = std::floor((end - t0) / macro);
      const Window window{t0 + (periods - 1) * macro, t0 + periods * macro};
      Json json{{"name", name},
                {"basic_period_ns", one.basic_period.count()},
                {"macro_period_ns", one.macro_period.count()},
                {"begin_ms", static_cast<double>(begins_ns + in_ns(window.from_us)) / 1e6},
                {"rows", Json::array()}};
      const auto thread = threads.rows.find(name);
      if (window.from_us < 0 || periods < 1 || thread == threads.rows.end()) {
        json["text"] = "the trace has no complete macro period";
      } else {
        json["rows"] = rows_json(trace, thread->second, window, basic);
        if (const auto other = threads.sporadic.find(name); other != threads.sporadic.end())
          add_sporadic(json["rows"], trace, other->second, window, basic);
        if (window.to_us - window.from_us > longest.to_us - longest.from_us) longest = window;
      }
      executors.push_back(std::move(json));
    }
    Json programs = Json::array();
    for (const Json& event : trace.at("traceEvents")) {
      if (event.value("cat", "") != "body" || !longest.holds(event.at("ts").get<double>())) continue;
      programs.push_back(run_json(event, longest));
    }
    return Json{{"executors", std::move(executors)}, {"programs", std::move(programs)}};
  } catch (const Json::exception&) {
    return fail("the trace of the device is from another version of Takt",
                "install the same version on all machines");
  }
}

}  // namespace takt::tool::web
