#include "watch/pages.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "reports/run_report.hpp"
#include "watch/list.hpp"
#include "watch/sparkline.hpp"

namespace takt::tool::watch {

namespace {

constexpr std::size_t kLabel = 13;

Line labelled(const std::string& label) {
  Line line;
  line.gap(2).left(label, kLabel, Ink::dim);
  return line;
}

/// Adds a text to the page, wrapped to the width of the terminal.
void add_wrapped(std::vector<Line>& page, const std::string& label, const std::string& text,
                 std::size_t columns, Ink ink = Ink::plain) {
  const std::size_t room = columns > kLabel + 12 ? columns - kLabel - 2 : 10;
  bool is_first = true;
  for (const std::string& line : wrapped(text, room))
    page.push_back(labelled(std::exchange(is_first, false) ? label : "").add(line, ink));
}

std::string quantiles_text(const Quantiles& of) {
  return fmt::format("p50 {}   p99 {}   p99.9 {}   max {} us", in_us(of.p50), in_us(of.p99), in_us(of.p999),
                     in_us(of.max));
}

void counters(std::vector<Line>& page, const Measured& m) {
  const auto count = [](Line& line, const char* what, std::uint64_t number, Ink ink) {
    line.add(fmt::format("{} {}", what, number), number == 0 ? Ink::plain : ink).gap(3);
  };
  Line line = labelled("cycles");
  line.add(std::to_string(m.cycles)).gap(3);
  count(line, "missed", m.missed, Ink::warning);
  count(line, "overruns", m.overruns, Ink::warning);
  count(line, "over budget", m.over_budget, Ink::warning);
  page.push_back(line);
  line = labelled("errors");
  line.add(std::to_string(m.errors), m.errors == 0 ? Ink::plain : Ink::bad).gap(3);
  count(line, "recoveries", m.recoveries, Ink::warning);
  page.push_back(line);
}

void last_minute(std::vector<Line>& page, const Module& module, std::size_t columns, ScreenStyle style) {
  constexpr std::size_t kHeight = 3;
  double most = -1;
  for (const double value : module.minute_us) most = std::isnan(value) ? most : std::max(most, value);
  if (most < 0) {
    page.push_back(labelled("last minute").add("the module did not run", Ink::dim));
    return;
  }
  const std::size_t room = columns > kLabel + 24 ? std::min<std::size_t>(columns - kLabel - 16, 60) : 20;
  const std::vector<std::string> bars = chart(module.minute_us, room, kHeight, style);
  for (std::size_t i = 0; i < kHeight; ++i) {
    Line line = labelled(i == 0 ? "last minute" : i == 1 ? "  rms jitter" : "  per second");
    line.add(bars[i]);
    line.gap().add(i == 0 ? in_us(most) + " us" : i + 1 == kHeight ? "0" : "", Ink::dim);
    page.push_back(line);
  }
}

void run_time(std::vector<Line>& page, const Module& module, std::size_t columns, ScreenStyle style) {
  const Quantiles& run = module.measured->run_us;
  if (!module.planned || !module.planned->budget) {
    page.push_back(labelled("run time").add(quantiles_text(run)));
    if (module.planned) page.push_back(labelled("").add("the descriptor gives no budget", Ink::dim));
    return;
  }
  const double budget_us = static_cast<double>(module.planned->budget->count()) / 1e3;
  const std::size_t room = columns > kLabel + 40 ? std::min<std::size_t>(columns - kLabel - 34, 40) : 10;
  const auto line_of = [&](const char* label, const char* what, double us) {
    const double share = us / budget_us;
    const Ink ink = share > 1 ? Ink::bad : share > 0.8 ? Ink::warning : Ink::good;
    Line line = labelled(label);
    line.left(what, 4, Ink::dim).right(in_us(us), 7).add(" us ");
    line.add(bar(share, room, style), ink).gap();
    line.add(fmt::format("{:.0f} %{}", share * 100, share > 1 ? " OVER" : ""),
             share > 0.8 ? ink : Ink::plain);
    return line;
  };
  page.push_back(line_of("run time", "p50", run.p50));
  page.push_back(line_of("  of budget", "p99", run.p99));
  page.push_back(line_of("", "max", run.max));
}

void ports(std::vector<Line>& page, const Module& module, const std::map<std::string, std::string>& values,
           std::size_t columns, ScreenStyle style) {
  if (module.ports.empty()) return;
  page.emplace_back();
  std::size_t name = 8;
  std::size_t type = 8;
  for (const Port& port : module.ports) {
    name = std::max(name, std::min<std::size_t>(columns_of(port.name), 24));
    type = std::max(type, std::min<std::size_t>(columns_of(port.type), columns > 100 ? 40 : 20));
  }
  Line heading;
  heading.gap(2).left("ports", 4 + name, Ink::title).gap().left("type", type, Ink::title).gap();
  page.push_back(heading.right("samples", 10, Ink::title).gap().add("connection", Ink::title));
  for (const Port& port : module.ports) {
    Line line;
    line.gap(2).left(port.output ? "out" : "in", 3, Ink::dim).gap().left(port.name, name).gap();
    line.left(port.type, type, Ink::dim).gap().count(port.samples, 10).gap();
    if (port.connected) {
      const State state =
          state_of(Connection{.from = {}, .to = {}, .kind = {}, .health = port.health}, style);
      line.add(state.text, state.ink);
    } else {
      line.add("not connected", Ink::dim);
    }
    page.push_back(line);
    if (const auto value = values.find(port.source); value != values.end())
      page.push_back(Line{}.gap(6).add(value->second));
  }
}

void transitions(std::vector<Line>& page, const Module& module) {
  constexpr std::size_t kShown = 5;
  if (module.transitions.empty()) return;
  page.emplace_back();
  const auto& all = module.transitions;
  const std::size_t shown = std::min(kShown, all.size());
  for (std::size_t i = 0; i < shown; ++i) {
    const Transition& each = all[all.size() - 1 - i];
    page.push_back(
        labelled(i == 0 ? "transitions" : "").add(clock_text(each.time_ns), Ink::dim).gap().add(each.text));
  }
}

std::vector<Line> module_page(const Device& device, const Module& module,
                              const std::map<std::string, std::string>& values, std::size_t columns,
                              ScreenStyle style) {
  std::vector<Line> page;
  const State state = state_of(device, module, style);
  page.push_back(labelled("state").add(state_text(state.text, device.alive && module.stopped), state.ink));
  if (!device.alive)
    page.push_back(labelled("").add("the device's node is lost; these are the last known values", Ink::dim));
  if (!module.text.empty()) add_wrapped(page, "why", module.text, columns);
  if (module.planned) {
    const Planned& planned = *module.planned;
    page.push_back(labelled("runs").add(planned.words));
    if (!planned.executor.empty())
      page.push_back(
          labelled("executor").add(fmt::format("{}, priority {}", planned.executor, planned.priority)));
    if (planned.budget) page.push_back(labelled("budget").add(takt::to_text(*planned.budget)));
  }
  if (!module.component.empty()) page.push_back(labelled("component").add(module.component));
  if (module.measured) {
    counters(page, *module.measured);
    page.emplace_back();
    page.push_back(labelled("jitter").add(quantiles_text(module.measured->jitter_us)));
    last_minute(page, module, columns, style);
    run_time(page, module, columns, style);
  } else {
    page.push_back(labelled("measured").add("no measurements yet", Ink::dim));
  }
  transitions(page, module);
  ports(page, module, values, columns, style);
  return page;
}

std::vector<Line> device_page(const Device& device, std::size_t columns, ScreenStyle style) {
  std::vector<Line> page;
  const State state = state_of(device, style);
  page.push_back(labelled("state").add(state.text, state.ink));
  page.push_back(labelled("health").add(device.health, device.health == "ok" ? Ink::good : Ink::bad));
  if (!device.text.empty()) add_wrapped(page, "why", device.text, columns);
  page.push_back(labelled("cell").add(device.cell.empty() ? "none; waiting for a deployment" : device.cell));
  page.push_back(labelled("machine").add(device.machine));
  page.push_back(labelled("node").add(fmt::format("process {}", device.process_id)));
  Line host = labelled("host");
  if (device.host_process_id == 0)
    host.add("none");
  else
    host.add(fmt::format("process {}", device.host_process_id));
  if (device.host_restarts > 0)
    host.add(
        fmt::format(", restarted {} {}", device.host_restarts, device.host_restarts == 1 ? "time" : "times"),
        Ink::warning);
  page.push_back(host);
  if (!device.cell.empty()) {
    page.push_back(
        device.real_time
            ? labelled("real time").add("yes")
            : labelled("real time").add("NO: the system denies real-time scheduling", Ink::warning));
  }
  const auto in = [&device](const char* name) {
    return std::count_if(device.modules.begin(), device.modules.end(),
                         [name](const Module& module) { return module.state == name; });
  };
  page.push_back(
      labelled("modules").add(fmt::format("{}, {} EXECUTING", device.modules.size(), in("EXECUTING"))));
  if (device.executors.empty()) return page;
  page.emplace_back();
  Line heading;
  heading.gap(2).left("executors", 12, Ink::title);
  for (const char* column : {"cycles", "missed", "late", "margin", "p50 us", "p99 us", "max us"})
    heading.gap().right(column, 8, Ink::title);
  page.push_back(heading);
  for (const Executor& each : device.executors) {
    Line line;
    line.gap(2).left(each.name, 12).gap().count(each.cycles, 8);
    line.gap().count(each.missed, 8, each.missed == 0 ? Ink::plain : Ink::warning);
    line.gap().count(each.late, 8, each.late == 0 ? Ink::plain : Ink::warning);
    for (const double us : {each.margin_us, each.jitter_us.p50, each.jitter_us.p99, each.jitter_us.max})
      line.gap().right(in_us(us), 8);
    page.push_back(line);
  }
  return page;
}

}  // namespace

std::vector<Line> details_page(const Snapshot& snapshot, const std::string& target, std::size_t columns,
                               ScreenStyle style) {
  const Device* const device = snapshot.device(target);
  const Module* const module = snapshot.module(target);
  if (device == nullptr || (module == nullptr && target.find('.') != std::string::npos))
    return {Line{}.gap(2).add(target + " no longer exists", Ink::warning)};
  return module != nullptr ? module_page(*device, *module, snapshot.values, columns, style)
                           : device_page(*device, columns, style);
}

std::vector<Line> connections_page(const Snapshot& snapshot, const std::string& filter, std::size_t columns,
                                   ScreenStyle style) {
  const auto note = [](const char* text) { return std::vector{Line{}.gap(2).add(text, Ink::dim)}; };
  if (!snapshot.connections_known) return note("no node has reported the connections yet");
  if (snapshot.connections.empty()) return note("the cell has no connections");
  std::vector<const Connection*> shown;
  std::size_t from = 4;
  std::size_t to = 2;
  for (const Connection& each : snapshot.connections) {
    if (!matches(each.from + " " + each.to + " " + each.kind + " " + state_of(each, style).text, filter))
      continue;
    shown.push_back(&each);
    from = std::max(from, columns_of(each.from));
    to = std::max(to, columns_of(each.to));
  }
  if (shown.empty()) return note("no connections match the filter");
  std::stable_partition(shown.begin(), shown.end(),
                        [style](const Connection* each) { return state_of(*each, style).ink == Ink::bad; });
  // The column "health" keeps its width, because it matters most; long names are cut instead.
  constexpr std::size_t kHealth = 26;
  const std::size_t names = columns > kHealth + 20 ? columns - kHealth - 5 : 20;
  if (from + to > names) {
    from = std::min(from, std::max(names / 2, names - std::min(to, names)));
    to = std::min(to, names - from);
  }
  std::vector<Line> page{Line{}
                             .gap(2)
                             .left("from", from, Ink::title)
                             .gap()
                             .left("to", to, Ink::title)
                             .gap()
                             .add("health", Ink::title)};
  for (const Connection* each : shown) {
    const State state = state_of(*each, style);
    page.push_back(
        Line{}.gap(2).left(each->from, from).gap().left(each->to, to).gap().add(state.text, state.ink));
  }
  return page;
}

std::vector<Line> help_page(ScreenStyle style) {
  struct Entry {
    const char* key;
    const char* text;
  };
  const Entry entries[] = {
      {"up down", "select a row (also k j); PgUp, PgDn, Home, End (also g G)"},
      {"Enter", "show details of the row; n, p: next, previous row; Esc: back"},
      {"/", "show only rows whose name, state or reason has all the words"},
      {"< >", "sort by the previous or next column; v reverses the order"},
      {"c", "show the connections and their health"},
      {"s t", "start or stop the module, or the whole device; confirm with y"},
      {"x R D", "reset, restart, destruct; confirm with y"},
      {"r i", "recover, initialize"},
      {"? q", "show this help; quit"},
      {"", ""},
      {"p50 p99", "jitter since the module was loaded: median, 99th percentile"},
      {"budget", "99th percentile of the run time, as a share of the budget"},
      {"over err", "overruns (cycles that ran past the next release); errors"},
  };
  std::vector<Line> page;
  for (const Entry& entry : entries)
    page.push_back(Line{}.gap(2).left(entry.key, 12, Ink::title).add(entry.text));
  const std::vector<double> steps{0, 1, 3, 10, 30, 100, 300, 1000};
  page.push_back(Line{}
                     .gap(2)
                     .left("last minute", 12, Ink::title)
                     .add("rms jitter per second; ")
                     .add(sparkline(steps, steps.size(), style))
                     .add(": below 1, from 1, 3, 10,"));
  page.push_back(Line{}.gap(14).add("30, 100, 300, 1000 us; blank: the module did not run"));
  const auto sign = [style](const char* state) {
    return state_of(Device{.name = {}, .cell = {}, .state = {}, .health = {}},
                    Module{.name = {}, .state = state}, style);
  };
  Line states;
  states.gap(2).left("states", 12, Ink::title);
  for (const char* each : {"EXECUTING", "START", "RECOVER", "DESTRUCT"})
    states.add(sign(each).text, sign(each).ink).gap(2);
  const State lost =
      state_of(Device{.name = {}, .cell = {}, .state = {}, .health = {}, .text = {}, .alive = false}, style);
  page.push_back(states.add(lost.text, lost.ink));
  return page;
}

}  // namespace takt::tool::watch
