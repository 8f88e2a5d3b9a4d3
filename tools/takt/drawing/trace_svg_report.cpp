#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "drawing/canvas.hpp"
#include "reports/page.hpp"
#include "reports/plot_report.hpp"
#include "reports/trace_report.hpp"

namespace takt::tool {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kTraceColours = R"(
.row { fill: #9aa6b2; }
.late { fill: #b3261e; }
.late-word { fill: #b3261e; font-weight: bold; }
)";
constexpr std::string_view kDarkTraceColours = R"(
.row { fill: #5c6773; }
.late { fill: #ff8a80; }
.late-word { fill: #ff8a80; }
)";

constexpr double kTraceWide = 900;
constexpr double kTraceLane = 18;
constexpr double kThin = 0.8;  // minimum width of a bar
constexpr std::size_t kNamedLate = 8;

struct Bar {
  double begin_us = 0;
  double took_us = 0;
  double late_us = 0;  ///< 0 if the run was not late
  std::string why{};
};

struct Lane {
  std::string name;
  std::string_view look;
  std::vector<Bar> bars{};
};

/// The lanes of one executor, or of all process modules.
struct Group {
  std::string title;
  std::vector<Lane> lanes{};

  Lane& lane(const std::string& name, std::string_view look) {
    const auto found =
        std::find_if(lanes.begin(), lanes.end(), [&name](const Lane& lane) { return lane.name == name; });
    return found != lanes.end() ? *found : lanes.emplace_back(Lane{name, look});
  }
};

Bar bar_of(const Json& event) {
  Bar bar{.begin_us = event.at("ts").get<double>(), .took_us = event.at("dur").get<double>()};
  if (event.contains("args") && event["args"].contains("begins_late_us")) {
    bar.late_us = event["args"]["begins_late_us"].get<double>();
    bar.why = event["args"].value("why", "");
  }
  return bar;
}

std::vector<Group> groups_of(const Json& trace) {
  std::vector<Group> groups;
  std::map<double, std::size_t> of_thread;  // index in `groups`, by the thread's id
  for (const Json& thread : trace.at("otherData").at("threads")) {
    const auto executor = thread.at("executor").get<std::string>();
    const std::string title = "executor " + executor;
    auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.title == title; });
    if (group == groups.end()) group = groups.insert(groups.end(), Group{title});
    of_thread[thread.at("thread").get<double>()] = static_cast<std::size_t>(group - groups.begin());
  }
  Group programs{"programs"};
  for (const Json& event : trace.at("traceEvents")) {
    const auto kind = event.value("cat", "");
    const auto name = event.value("name", "");
    if (kind == "body") programs.lane(name, "process").bars.push_back(bar_of(event));
    if (kind != "row" && kind != "run") continue;
    const auto group = of_thread.find(event.at("tid").get<double>());
    if (group == of_thread.end()) continue;
    Lane& lane = kind == "row" ? groups[group->second].lane("rows", "row")
                               : groups[group->second].lane(name, "thread");
    lane.bars.push_back(bar_of(event));
  }
  groups.push_back(std::move(programs));
  std::erase_if(groups, [](const Group& group) { return group.lanes.empty(); });
  return groups;
}

class TraceDrawing {
 public:
  TraceDrawing(const TraceSummary& summary, std::vector<Group> groups)
      : summary_(summary), groups_(std::move(groups)), to_us_(summary.lasts_us) {
    leave_out();
    unit_ = unit_of_time((to_us_ - from_us_) / 1e6);
    for (const Group& group : groups_) {
      for (const Lane& lane : group.lanes)
        left_ = std::max(left_, kMargin + 10 + width_of(lane.name, kSmall) + 10);
    }
  }

  std::string svg() {
    double y = kMargin + 14;
    const std::string title = summary_.cell + "." + summary_.device;
    canvas_.text(kMargin, y, kLarge + 4, "title", title);
    y += 20;
    canvas_.text(kMargin, y, kNormal, "faint",
                 fmt::format("{}{} on {}; taken: {}", span(to_us_ - from_us_),
                             from_us_ > 0 ? fmt::format(", the end of a trace of {}", span(to_us_)) : "",
                             summary_.machine, summary_.why));
    y += 10;
    for (const Group& group : groups_) y = draw(group, y + 22);
    if (groups_.empty()) y = nothing(y + 10);
    axis(y);
    late(y + 44);
    return canvas_.document(title, kTraceColours, kDarkTraceColours);
  }

 private:
  /// Removes the oldest bars if there are too many to distinguish.
  void leave_out() {
    std::vector<double> begins;
    for (const Group& group : groups_) {
      for (const Lane& lane : group.lanes) {
        for (const Bar& bar : lane.bars) begins.push_back(bar.begin_us);
      }
    }
    if (begins.size() <= kTraceBars) return;
    const auto first = begins.end() - static_cast<std::ptrdiff_t>(kTraceBars);
    std::nth_element(begins.begin(), first, begins.end());
    from_us_ = *first;
    for (Group& group : groups_) {
      for (Lane& lane : group.lanes)
        std::erase_if(lane.bars, [this](const Bar& bar) { return bar.begin_us < from_us_; });
    }
  }

  static std::string span(double us) {
    const TimeUnit unit = unit_of_time(us / 1e6);
    return fmt::format("{:.4g} {}", us / 1e6 / unit.seconds, unit.name);
  }
  [[nodiscard]] double x_of(double us) const {
    const double share = (us - from_us_) / std::max(to_us_ - from_us_, 1e-9);
    return left_ + kTraceWide * std::clamp(share, 0.0, 1.0);
  }

  double draw(const Group& group, double y) {
    canvas_.text(kMargin, y, kNormal, "title", group.title);
    y += 8;
    bool odd = false;
    for (std::size_t i = 0; i < group.lanes.size(); ++i)
      canvas_.rectangle(left_, y + kTraceLane * static_cast<double>(i), kTraceWide, kTraceLane,
                        (odd = !odd) ? "panel" : "odd");
    grid(y, y + kTraceLane * static_cast<double>(group.lanes.size()));
    for (const Lane& lane : group.lanes) {
      canvas_.text(kMargin + 10, y + 13, kSmall, "", lane.name);
      for (const Bar& bar : lane.bars) draw(lane, bar, y);
      y += kTraceLane;
    }
    return y;
  }

  void draw(const Lane& lane, const Bar& bar, double y) {
    const double left = x_of(bar.begin_us);
    const double wide = std::max(x_of(bar.begin_us + bar.took_us) - left, kThin);
    if (bar.late_us <= 0) {
      canvas_.rectangle(left, y + 3, wide, kTraceLane - 6, lane.look);
      return;
    }
    canvas_.open_group(fmt::format("{}: {} late: {}", lane.name, span(bar.late_us), bar.why));
    canvas_.rectangle(left, y + 3, wide, kTraceLane - 6, lane.look);
    canvas_.diamond(left, y + kTraceLane / 2, 4, "late");
    canvas_.close_group();
  }

  /// Draws one empty lane, for a trace without runs.
  double nothing(double y) {
    canvas_.rectangle(left_, y, kTraceWide, kTraceLane, "panel");
    grid(y, y + kTraceLane);
    canvas_.text(left_ + 10, y + 13, kSmall, "faint", "no module ran in this time");
    return y + kTraceLane;
  }

  [[nodiscard]] std::vector<double> marks() const {
    return ticks(from_us_ / 1e6 / unit_.seconds, to_us_ / 1e6 / unit_.seconds, 9);
  }

  /// Draws the grid behind the bars of one group. The grid does not extend behind the group's title, which
  /// may be longer than the names of the lanes.
  void grid(double top, double bottom) {
    for (const double mark : marks()) {
      const double x = x_of(mark * unit_.seconds * 1e6);
      canvas_.line(x, top, x, bottom, "grid");
    }
  }

  void axis(double bottom) {
    for (const double mark : marks()) {
      const double x = x_of(mark * unit_.seconds * 1e6);
      canvas_.line(x, bottom, x, bottom + 4, "grid");
      canvas_.centred(x, bottom + 14, kSmall, "faint", fmt::format("{:.6g}", mark + 0.0));  // + 0.0: no -0
    }
    canvas_.centred(left_ + kTraceWide / 2, bottom + 30, kSmall, "faint",
                    fmt::format("time in {}", unit_.name));
  }

  void late(double y) {
    y += 8;
    if (summary_.late.empty()) {
      canvas_.text(kMargin, y, kNormal, "faint", "No row and no module began late.");
      return;
    }
    canvas_.diamond(kMargin + 4, y - 4, 4, "late");
    canvas_.text(
        kMargin + 14, y, kNormal, "late-word",
        "began late: " + count(summary_.late.size(), "start") +
            (summary_.late.size() > kNamedLate ? fmt::format("; the worst {} are:", kNamedLate) : ""));
    for (std::size_t i = 0; i < std::min(summary_.late.size(), kNamedLate); ++i) {
      const TracedStart& start = summary_.late[i];
      y += 16;
      canvas_.text(kMargin + 14, y, kSmall, "",
                   fmt::format("at {}{}: {}, {} late: {}; {}", span(start.at_us),
                               start.at_us < from_us_ ? " (not drawn)" : "", start.what, span(start.late_us),
                               start.cause, start.why));
    }
  }

  const TraceSummary& summary_;
  std::vector<Group> groups_;
  double from_us_ = 0;
  double to_us_;
  double left_ = kMargin;
  TimeUnit unit_{};
  Canvas canvas_;
};

}  // namespace

Result<std::string> trace_svg(const Json& trace) {
  const auto summary = summary_of(trace);
  if (!summary) return summary.problems();
  try {
    return TraceDrawing{*summary, groups_of(trace)}.svg();
  } catch (const Json::exception&) {
    return fail("its events are not in the format of a Takt trace");
  }
}

}  // namespace takt::tool
