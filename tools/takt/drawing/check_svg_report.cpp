// Draws the tables of a cell as SVG.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string_view>

#include <fmt/format.h>

#include <takt/core/check.hpp>

#include "drawing/canvas.hpp"
#include "reports/check_report.hpp"

namespace takt::tool {
namespace {

using model::Device;
using model::Module;
using model::ModuleType;
using schedule::DevicePlan;
using schedule::ExecutorPlan;

// The sizes below are in pixels.
constexpr double kScheduleLane = 32;
constexpr double kBadge = 15;  // height of the mark of a release
constexpr double kStrip = 44;  // height of the strip that shows the load
constexpr double kPlot = 960;  // preferred width of all rows together

// A row's load above kHigh is drawn as high, above kFull as full. Both are shares of the basic period.
constexpr double kHigh = 0.7;
constexpr double kFull = 0.9;

constexpr std::string_view kScheduleColours =
    R"(.thread-budget { fill: #6da5e0; }
.process-budget { fill: #dfa254; }
.deadline { stroke: #b3261e; stroke-width: 1.5; stroke-dasharray: 4 3; }
.end { stroke: #b3261e; stroke-width: 2; }
.low { fill: #4b9e6a; }
.high { fill: #d08a1d; }
.full { fill: #c8372d; }
)";

constexpr std::string_view kDarkScheduleColours =
    R"(.thread-budget { fill: #3f76b5; }
.process-budget { fill: #99631f; }
.deadline, .end { stroke: #ff8a80; }
.low { fill: #56b37a; }
.high { fill: #e0a040; }
.full { fill: #f0685e; }
)";

double ratio_of(Nanoseconds part, Nanoseconds whole) {
  return static_cast<double>(part.count()) / static_cast<double>(whole.count());
}

std::string count_text(std::size_t value) { return std::to_string(value); }

/// The timing of a module as text: "thread, every 1 ms, priority 2, budget 200 us".
std::string timing_of(const Module& module) {
  std::string text = model::to_text(module.type);
  if (module.period) text += ", every " + to_text(*module.period);
  if (module.deadline) text += ", deadline " + to_text(*module.deadline);
  text += ", priority " + std::to_string(module.priority);
  if (module.budget) text += ", budget " + to_text(*module.budget);
  return text;
}

std::string kind(const Module& module) { return module.type == ModuleType::thread ? "thread" : "process"; }

/// Draws the table of one executor: its rows, modules and load.
class Panel {
 public:
  Panel(Canvas& canvas, const Device& device, const ExecutorPlan& plan, double y, double label)
      : canvas_{canvas}, device_{device}, plan_{plan}, y_{y}, left_{kMargin + label} {
    shown_ = std::min(plan.rows(), kSvgRows);
    // Make the marks of releases wide enough for their numbers.
    std::size_t longest = 1;
    for (std::size_t row = 0; row < shown_; ++row) longest = std::max(longest, plan_.row(row).size());
    badge_ = width_of(count_text(longest), kSmall) + 8;
    if (shown_ > 0) column_ = std::clamp(kPlot / static_cast<double>(shown_), badge_ + 3, 240.0);
    right_ = left_ + column_ * static_cast<double>(shown_);
  }

  /// Draws the panel, and returns the y coordinate below it.
  double draw() {
    const model::Executor& executor = device_.executors[plan_.executor];
    y_ += 30;
    canvas_.text(kMargin, y_, kLarge, "title", device_.name + ", executor " + executor.name);
    y_ += 18;
    canvas_.text(kMargin, y_, kNormal, "faint", summary(executor));
    if (plan_.rows() == 0) return y_ + 12;
    if (shown_ < plan_.rows()) {
      y_ += 16;
      canvas_.text(kMargin, y_, kNormal, "faint",
                   "only rows 0 to " + count_text(shown_ - 1) + " of " + count_text(plan_.rows()) +
                       " are drawn; takt check --json lists them all");
    }
    y_ += 22;
    background();
    const std::vector<std::uint32_t> tasks = by_priority();
    for (std::size_t i = 0; i < std::min(tasks.size(), kSvgLanes); ++i) periodic_lane(tasks[i]);
    left_out(plan_.periodic.size(), "periodic");
    for (std::size_t i = 0; i < std::min(plan_.sporadic.size(), kSvgLanes); ++i)
      sporadic_lane(plan_.sporadic[i]);
    left_out(plan_.sporadic.size(), "sporadic");
    if (!plan_.periodic.empty()) load_strip();
    axis();
    return y_;
  }

 private:
  [[nodiscard]] double at(std::size_t row) const { return left_ + column_ * static_cast<double>(row); }

  [[nodiscard]] std::string summary(const model::Executor& executor) const {
    const std::string how = (executor.cpu ? "cpu " + std::to_string(*executor.cpu) : "any cpu") +
                            ", priority " + std::to_string(executor.priority) + ", wakeup " +
                            model::to_text(executor.wakeup);
    if (plan_.rows() == 0) return "no modules; " + how;
    return "basic period " + to_text(plan_.basic_period) + ", macro period " + to_text(plan_.macro_period) +
           ", " + count_text(plan_.rows()) + (plan_.rows() == 1 ? " row; " : " rows; ") + how;
  }

  [[nodiscard]] double lanes_height() const {
    const auto lanes = [](std::size_t modules) {
      return static_cast<double>(std::min(modules, kSvgLanes) + (modules > kSvgLanes ? 1 : 0));
    };
    return kScheduleLane * (lanes(plan_.periodic.size()) + lanes(plan_.sporadic.size())) +
           (plan_.periodic.empty() ? 0 : kStrip);
  }

  /// Draws the row numbers and the grid of basic periods.
  void background() {
    const double height = lanes_height();
    canvas_.text(kMargin, y_, kSmall, "faint", "row");
    const auto every = step(width_of(count_text(shown_), kSmall) + 6);
    for (std::size_t row = 0; row < shown_; row += every) {
      canvas_.centred(at(row) + column_ / 2, y_, kSmall, "faint", count_text(row));
    }
    y_ += 6;
    canvas_.rectangle(kMargin, y_, right_ - kMargin, height, "panel");
    for (std::size_t row = 0; row < shown_; row += 2) canvas_.rectangle(at(row), y_, column_, height, "odd");
    for (std::size_t row = 0; row <= shown_; ++row) canvas_.line(at(row), y_, at(row), y_ + height, "grid");
  }

  /// The periodic modules in the order in which a row runs them. The lanes are in this order, from the top.
  [[nodiscard]] std::vector<std::uint32_t> by_priority() const {
    std::vector<std::uint32_t> tasks(plan_.periodic.size());
    std::iota(tasks.begin(), tasks.end(), 0U);
    std::stable_sort(tasks.begin(), tasks.end(), [&](auto a, auto b) {
      return device_.modules[plan_.periodic[a]].priority < device_.modules[plan_.periodic[b]].priority;
    });
    return tasks;
  }

  /// The number of rows over which a text of this width extends.
  [[nodiscard]] std::size_t step(double width) const {
    return static_cast<std::size_t>(std::max(1.0, std::ceil(width / column_)));
  }

  void label(const Module& module) {
    canvas_.line(kMargin, y_ + kScheduleLane, right_, y_ + kScheduleLane, "lane");
    canvas_.text(kMargin + 6, y_ + 14, kNormal, "", module.name);
    canvas_.text(kMargin + 6, y_ + 26, kSmall, "faint", timing_of(module));
  }

  void periodic_lane(std::uint32_t task) {
    const Module& module = device_.modules[plan_.periodic[task]];
    canvas_.open_group(module.name + ": " + timing_of(module));
    label(module);
    for (std::size_t row = 0; row < shown_; ++row) {
      // A process module runs in parallel to the row. A thread module runs after the thread modules that
      // precede it in the row.
      double before = 0;
      std::size_t order = 0;
      bool due = false;
      for (const auto other : plan_.table.row(row)) {
        ++order;
        due = other == task;
        if (due) break;
        const Module& earlier = device_.modules[plan_.periodic[other]];
        if (earlier.type == ModuleType::thread && earlier.budget)
          before += ratio_of(*earlier.budget, plan_.basic_period);
      }
      if (!due) continue;
      if (module.budget) {
        const double begin = at(row) + column_ * (module.type == ModuleType::thread ? before : 0);
        const double end = std::min(begin + column_ * ratio_of(*module.budget, plan_.basic_period), right_);
        canvas_.rectangle(begin, y_ + 23, std::max(end - begin, 1.0), 6, kind(module) + "-budget");
      }
      canvas_.rectangle(at(row) + 1, y_ + 5, badge_, kBadge, kind(module), 3);
      canvas_.centred(at(row) + 1 + badge_ / 2, y_ + 5 + kBadge - 4, kSmall, "on", count_text(order));
    }
    canvas_.close_group();
    y_ += kScheduleLane;
  }

  /// The x coordinate at which the executor checks the conditions of sporadic modules in this row: after the
  /// row's thread modules have run.
  [[nodiscard]] double check_at(std::size_t row) const {
    const double load = ratio_of(plan_.load(device_, row).budget, plan_.basic_period);
    return at(row) +
           std::clamp(column_ * load, std::min(badge_, column_ / 2), std::max(column_ - 7, column_ / 2));
  }

  void sporadic_lane(std::uint32_t index) {
    const Module& module = device_.modules[index];
    canvas_.open_group(module.name + ": " + timing_of(module));
    label(module);
    const double middle = y_ + kScheduleLane / 2;
    const double end = check_at(0) + column_ * ratio_of(*module.deadline, plan_.basic_period);
    canvas_.line(check_at(0), middle, std::min(end, right_), middle, "deadline");
    for (std::size_t row = 0; row < shown_; ++row) canvas_.diamond(check_at(row), middle, 5, kind(module));
    if (end < right_) canvas_.line(end, middle - 9, end, middle + 9, "end");
    canvas_.close_group();
    y_ += kScheduleLane;
  }

  void left_out(std::size_t modules, std::string_view what) {
    if (modules <= kSvgLanes) return;
    canvas_.text(kMargin + 6, y_ + 20, kNormal, "faint",
                 "and " + count_text(modules - kSvgLanes) + " more " + std::string{what} + " modules");
    y_ += kScheduleLane;
  }

  void load_strip() {
    canvas_.text(kMargin + 6, y_ + 18, kNormal, "", "load");
    bool stated = false;
    bool named = true;  // every row has space for its load as a number
    bool complete = true;
    const double tall = kStrip - 18;
    for (std::size_t row = 0; row < shown_; ++row) {
      const auto load = plan_.load(device_, row);
      complete = complete && load.complete;
      if (load.budget == Nanoseconds{}) continue;
      stated = true;
      const double share = ratio_of(load.budget, plan_.basic_period);
      const double height = std::max(1.0, tall * share);
      canvas_.rectangle(at(row) + 2, y_ + kStrip - height, column_ - 4, height,
                        share > kFull   ? "full"
                        : share > kHigh ? "high"
                                        : "low");
      const std::string text = fmt::format("{}{:.0f}%", load.complete ? "" : ">", 100 * share);
      if (width_of(text, kSmall) <= column_ - 2) {
        canvas_.centred(at(row) + column_ / 2, y_ + kStrip - height - 3, kSmall, "", text);
      } else {
        named = false;
      }
    }
    canvas_.text(kMargin + 6, y_ + 32, kSmall, "faint",
                 !stated    ? "no thread has a budget"
                 : complete ? "sum of thread budgets"
                            : "minimum: some have no budget");
    if (!named) {
      canvas_.line(left_, y_ + kStrip - tall, right_, y_ + kStrip - tall, "grid");
      canvas_.text_before(left_ - 4, y_ + kStrip - tall + 2, kSmall, "faint", "100%");
    }
    y_ += kStrip;
  }

  /// Draws the time axis below the grid. The axis always shows the time of the end of the last row.
  void axis() {
    canvas_.line(left_, y_, right_, y_, "grid");
    const auto time = [&](std::size_t row) {
      return row == 0 ? "0" : to_text(plan_.basic_period * static_cast<std::int64_t>(row));
    };
    double widest = 0;
    for (std::size_t row = 0; row <= shown_; ++row)
      widest = std::max(widest, width_of(time(row), kSmall) + 12);
    const auto every = step(widest);
    for (std::size_t row = 0; row <= shown_; row += every) {
      if (row != shown_ && at(row) + widest > right_) continue;
      canvas_.line(at(row), y_, at(row), y_ + 4, "grid");
      canvas_.centred(at(row), y_ + 15, kSmall, "faint", time(row));
    }
    if (shown_ % every != 0) {
      canvas_.line(right_, y_, right_, y_ + 4, "grid");
      canvas_.centred(right_, y_ + 15, kSmall, "faint", time(shown_));
    }
    y_ += 26;
  }

  Canvas& canvas_;
  const Device& device_;
  const ExecutorPlan& plan_;
  double y_;
  double left_;
  double right_ = 0;
  double column_ = 0;
  double badge_ = 0;
  std::size_t shown_ = 0;
};

/// The width of the labels to the left of the rows. It is the same for all panels, so that their rows are
/// aligned.
double label_width(const model::Cell& cell) {
  double widest = width_of("minimum: some have no budget", kSmall);
  for (const Device& device : cell.devices) {
    for (const Module& module : device.modules) {
      if (module.operation == model::Operation::non_real) continue;
      widest = std::max({widest, width_of(module.name, kNormal), width_of(timing_of(module), kSmall)});
    }
  }
  return widest + 20;
}

/// Lists the modules that are not real-time, wrapped to the width of the drawing.
double names_below(Canvas& canvas, double y, const Device& device,
                   const std::vector<std::uint32_t>& modules) {
  std::string line = device.name + ", modules that are not real-time:";
  const auto flush = [&] {
    y += 16;
    canvas.text(kMargin, y, kNormal, "faint", line);
  };
  for (std::size_t i = 0; i < modules.size(); ++i) {
    const Module& module = device.modules[modules[i]];
    const std::string word =
        " " + module.name + " (" + kind(module) + ")" + (i + 1 < modules.size() ? "," : "");
    if (width_of(line + word, kNormal) > kPlot) {
      flush();
      line = "   ";
    }
    line += word;
  }
  flush();
  return y + 8;
}

/// The kinds of elements that a drawing contains, so that the legend explains only these.
struct Shown {
  bool threads = false;
  bool processes = false;
  bool sporadic_threads = false;
  bool sporadic_processes = false;
  bool thread_budgets = false;
  bool process_budgets = false;

  [[nodiscard]] bool sporadic() const { return sporadic_threads || sporadic_processes; }
};

Shown shown(const model::Cell& cell) {
  Shown shown;
  for (const Device& device : cell.devices) {
    for (const Module& module : device.modules) {
      const bool thread = module.type == ModuleType::thread;
      if (module.operation == model::Operation::sporadic)
        (thread ? shown.sporadic_threads : shown.sporadic_processes) = true;
      if (module.operation != model::Operation::periodic) continue;
      (thread ? shown.threads : shown.processes) = true;
      if (module.budget) (thread ? shown.thread_budgets : shown.process_budgets) = true;
    }
  }
  return shown;
}

double legend(Canvas& canvas, double y, const Shown& shown) {
  const double sample = kMargin + 6;
  const double words = kMargin + 52;
  const auto entry = [&](std::string_view text) {
    canvas.text(words, y + 12, kSmall, "faint", text);
    y += 20;
  };
  y += 16;
  if (shown.threads) {
    canvas.rectangle(sample, y, 15, kBadge, "thread", 3);
    canvas.centred(sample + 7.5, y + kBadge - 4, kSmall, "on", "1");
    entry("release of a thread module; the number is the module's position in the row");
  }
  if (shown.processes) {
    canvas.rectangle(sample, y, 15, kBadge, "process", 3);
    canvas.centred(sample + 7.5, y + kBadge - 4, kSmall, "on", "2");
    entry("release of a process module, which runs on another CPU");
  }
  if (shown.thread_budgets || shown.process_budgets) {
    if (shown.thread_budgets) canvas.rectangle(sample, y + 2, 36, 5, "thread-budget");
    if (shown.process_budgets) canvas.rectangle(sample, y + 9, 36, 5, "process-budget");
    entry(
        "budget, to scale; a thread module is drawn after the budgets of the thread modules that precede it "
        "in the row");
  }
  if (shown.sporadic()) {
    if (shown.sporadic_threads) canvas.diamond(sample + 6, y + 8, 5, "thread");
    if (shown.sporadic_processes) canvas.diamond(sample + 24, y + 8, 5, "process");
    entry(
        "end of the row: the executor checks the condition of a sporadic thread module, or releases a "
        "sporadic process module");
    canvas.line(sample, y + 8, sample + 34, y + 8, "deadline");
    canvas.line(sample + 34, y + 2, sample + 34, y + 14, "end");
    entry(
        "deadline of a sporadic module that is released in the first row; if the line has no end mark, the "
        "deadline lies beyond the drawing");
  }
  if (shown.thread_budgets) {
    canvas.rectangle(sample, y + 9, 10, 5, "low");
    canvas.rectangle(sample + 12, y + 6, 10, 8, "high");
    canvas.rectangle(sample + 24, y + 3, 10, 11, "full");
    entry(fmt::format("load of a row: up to {:.0f}%, up to {:.0f}%, or above", 100 * kHigh, 100 * kFull));
  }
  return y;
}

}  // namespace

std::string check_svg(const model::Cell& cell, const std::vector<DevicePlan>& plans) {
  TAKT_CHECK(plans.size() == cell.devices.size());
  Canvas canvas;
  double y = kMargin + 14;
  canvas.text(kMargin, y, kLarge + 4, "title", cell.name);
  const double label = label_width(cell);
  for (std::size_t i = 0; i < plans.size(); ++i) {
    for (const ExecutorPlan& plan : plans[i].executors)
      y = Panel{canvas, cell.devices[i], plan, y, label}.draw() + 8;
    if (!plans[i].non_realtime.empty()) y = names_below(canvas, y, cell.devices[i], plans[i].non_realtime);
  }
  legend(canvas, y, shown(cell));

  return canvas.document("The schedule of " + cell.name, kScheduleColours, kDarkScheduleColours);
}

}  // namespace takt::tool
