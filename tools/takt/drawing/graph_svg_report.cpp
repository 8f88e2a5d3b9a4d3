#include <algorithm>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "drawing/canvas.hpp"
#include "drawing/graph_layout.hpp"
#include "reports/connections_report.hpp"
#include "reports/graph_report.hpp"

namespace takt::tool {
namespace {

using namespace graph;
using model::Connection;
using model::ConnectionKind;

constexpr std::string_view kGraphColours = R"(
.module { fill: #ffffff; stroke: #c3ccd5; stroke-width: 1; }
.frame { stroke: #c3ccd5; stroke-width: 1; }
.outside { stroke-dasharray: 5 4; }
.pin { fill: #5c6773; }
.halo { fill: none; stroke: #ffffff; stroke-width: 5; }
.wire { fill: none; stroke: #5c6773; stroke-width: 1.4; }
.queue { stroke-width: 2.6; }
.joint { stroke: #5c6773; stroke-width: 2; }
.head { fill: #5c6773; }
g.link:hover .wire { stroke-width: 4; }
.good { stroke: #2c7a4b; }
.poor { stroke: #a86400; }
.bad { stroke: #b3261e; stroke-dasharray: 6 4; }
.broken { stroke: #b3261e; stroke-dasharray: 1.5 4; }
.good-word { fill: #2c7a4b; }
.poor-word { fill: #a86400; }
.bad-word { fill: #b3261e; font-weight: bold; }
)";

constexpr std::string_view kDarkGraphColours = R"(
.module { fill: #14181d; stroke: #3d4854; }
.frame { stroke: #3d4854; }
.pin { fill: #9aa6b2; }
.halo { stroke: #14181d; }
.wire { stroke: #9aa6b2; }
.head { fill: #9aa6b2; }
.joint { stroke: #9aa6b2; }
.good { stroke: #56b37a; }
.poor { stroke: #e0a040; }
.bad, .broken { stroke: #ff8a80; }
.good-word { fill: #56b37a; }
.poor-word { fill: #e0a040; }
.bad-word { fill: #ff8a80; }
)";

class GraphDrawing {
 public:
  GraphDrawing(const model::Cell& cell, const CellHealth& health, const GraphPage* page)
      : cell_(cell), health_(health), page_(page), layout_(lay_out(cell, health, page)) {}

  std::string draw() {
    draw_title();
    for (const Column& column : layout_.columns) draw_column(column);
    for (const Wire& wire : layout_.wires) draw_wire(wire);
    for (const Wire& wire : layout_.wires) {
      if (wire.branches) canvas_.circle(wire.way[1].x, wire.way[1].y, 3, "head");
    }
    for (const Wire& wire : layout_.wires) draw_label(wire);
    draw_legend();
    return canvas_.document("The cell " + cell_.name, kGraphColours, kDarkGraphColours);
  }

 private:
  void draw_title();
  void draw_column(const Column& column);
  void draw_fold(const Column& column);
  void draw_box(const Column& column, const Box& box);
  void draw_measures(double left, double top);
  void draw_port(double left, double right, const Port& port);
  void draw_wire(const Wire& wire);
  void draw_label(const Wire& wire);
  void draw_legend();

  [[nodiscard]] const Connection& connection_of(const Wire& wire) const {
    return cell_.connections[wire.connections.front()];
  }
  [[nodiscard]] static std::string numbers_of(const Wire& wire) {
    return fmt::format("{}", fmt::join(wire.connections, " "));
  }
  /// The CSS classes of a word that names a state or health. The page of `takt web` finds these words by the
  /// class `state` and replaces them.
  [[nodiscard]] static std::string word_of(Look look) { return std::string{look.word} + " state"; }
  [[nodiscard]] std::string title_of(const Wire& wire) const;
  /// The health of a wire's connection, or null if it is not known.
  [[nodiscard]] const CellHealth::Connection* health_of(const Wire& wire) const {
    const auto found = health_.connections.find(wire.connections.front());
    return found == health_.connections.end() ? nullptr : &found->second;
  }

  const model::Cell& cell_;
  const CellHealth& health_;
  const GraphPage* page_;
  Layout layout_;
  Canvas canvas_;
};

void GraphDrawing::draw_title() {
  if (page_ == nullptr) canvas_.text(kMargin, kMargin + 14, kLarge + 4, "title", cell_.name);
  std::string about =
      count(cell_.devices.size(), "device") + ", " + count(cell_.connections.size(), "connection");
  if (is_on_network(cell_)) about += "; " + network_text(cell_);
  constexpr std::size_t kLongest = 160;
  if (about.size() > kLongest) about = about.substr(0, kLongest) + "...";
  canvas_.text(kMargin, page_ == nullptr ? kMargin + 34 : kMargin + 8, kNormal, "faint", about);
}

void GraphDrawing::draw_column(const Column& column) {
  const double x = column.left + kInside;
  if (column.outside)
    canvas_.open_group("programs outside Takt");
  else
    canvas_.open_group("device " + column.name, "column", "device", column.name);
  canvas_.rectangle(column.left, column.top, column.width, column.bottom - column.top,
                    column.outside ? "panel frame outside" : "panel frame", 6);
  canvas_.text(x, column.top + 19, kLarge, "title", column.name);
  if (!column.about.empty()) canvas_.text(x, column.top + 33, kSmall, "faint", column.about);
  if (!column.state.empty()) canvas_.text(x, column.top + 47, kSmall, word_of(column.look), column.state);
  canvas_.close_group();
  if (page_ != nullptr && !column.outside) draw_fold(column);
  for (const Box& box : column.boxes) draw_box(column, box);
  if (column.left_out == 0) return;
  canvas_.text(x, column.bottom - 12, kSmall, "faint", "and " + count(column.left_out, "module") + " more");
}

/// Draws the control that collapses or expands a device.
void GraphDrawing::draw_fold(const Column& column) {
  // It stays inside the rounded border of the device.
  const double x = column.right() - kFold - 2;
  const double y = column.top + 2;
  canvas_.open_group((column.collapsed ? "expand device " : "collapse device ") + column.name, "fold", "fold",
                     column.name);
  canvas_.rectangle(x, y, kFold, kFold, "panel", 4);
  canvas_.line(x + 7, y + 12, x + 17, y + 12, "joint");
  if (column.collapsed) canvas_.line(x + 12, y + 7, x + 12, y + 17, "joint");
  canvas_.close_group();
}

/// Draws what the page fills in: the run time as words and a bar, the jitter as words and its trend.
void GraphDrawing::draw_measures(double left, double top) {
  const double right = left + kRoomForMeasures;
  const double middle = (left + right) / 2;
  canvas_.text(left, top + 10, kSmall, "faint run", "");
  canvas_.rectangle(left, top + 15, right - left, 6, "track", 3);
  canvas_.rectangle(left, top + 15, 0, 6, "used", 3);
  canvas_.text(left, top + 34, kSmall, "faint jitter", "");
  canvas_.rectangle(middle + kInside, top + 24, right - middle - kInside, 14, "trend");
}

void GraphDrawing::draw_box(const Column& column, const Box& box) {
  const double left = column.left + kInside;
  const double right = column.right() - kInside;
  const double x = left + kInside / 2;
  if (column.collapsed && box.ports.empty()) return;
  if (column.collapsed || column.outside)
    canvas_.open_group(column.collapsed ? "connections of device " + column.name : box.title);
  else
    canvas_.open_group(box.title, "box", "module", column.name + "." + box.name);
  canvas_.rectangle(left, box.top, right - left, box.height, "module", 4);
  if (!column.collapsed) {
    canvas_.text(x, box.top + 15, kNormal, "title", box.name);
    canvas_.text(x, box.top + 28, kSmall, "faint", box.about);
  }
  if (!box.state.empty()) canvas_.text(x, box.top + 40, kSmall, word_of(box.look), box.state);
  if (page_ != nullptr && !box.state.empty()) draw_measures(x, box.top + 44);
  for (const Port& port : box.ports) draw_port(left, right, port);
  canvas_.close_group();
}

std::string GraphDrawing::title_of(const Wire& wire) const {
  if (wire.connections.size() > 1) return label_of(cell_, wire);
  const Connection& connection = connection_of(wire);
  const auto* health = health_of(wire);
  return end_text(connection.from) + " -> " + end_text(connection.to) + ": " + described(connection) +
         (health == nullptr ? "" : "; " + health_text(*health));
}

/// Draws the name of a port on the side of its wires, and a mark that points in the direction of the data.
void GraphDrawing::draw_port(double left, double right, const Port& port) {
  const bool at_right = port.named_at_right();
  const double outer = at_right ? right - 5 : left + 5;
  const double inner = at_right ? outer - 7 : outer + 7;
  const double tip = port.input ? inner : outer;
  const double back = port.input ? outer : inner;
  canvas_.path({{back, port.y - 4}, {tip, port.y}, {back, port.y + 4}}, "pin", true);
  if (at_right) {
    canvas_.text_before(inner - 3, port.y + 4, kSmall, "", port.name);
  } else {
    canvas_.text(inner + 3, port.y + 4, kSmall, "", port.name);
  }
  // If the port has wires on both sides, draw a line from its name to the other side.
  if (!port.left.empty() && !port.right.empty()) {
    const double named = inner + (at_right ? -1 : 1) * (width_of(port.name, kSmall) + 9);
    canvas_.line(std::min(named, at_right ? left : right), port.y, std::max(named, at_right ? left : right),
                 port.y, "grid");
  }
  // If an input has several wires on one side, join them with a bar.
  for (const bool side : {false, true}) {
    if (!port.input) break;
    const auto& wires = side ? port.right : port.left;
    const double x = side ? right : left;
    if (wires.size() < 2) continue;
    canvas_.line(x, port.y, x, port.y + layout_.pitch * static_cast<double>(wires.size() - 1), "joint");
  }
}

void GraphDrawing::draw_wire(const Wire& wire) {
  const Connection& connection = connection_of(wire);
  const CellHealth::Connection* health = health_of(wire);
  std::string classes = connection.kind == ConnectionKind::queue ? "wire queue" : "wire";
  if (health != nullptr) classes += " " + std::string{look_of(*health).line};
  // End the line where the arrow head begins.
  std::vector<Point> way = wire.way;
  const Point tip = way.back();
  way.back().x += wire.to.at_right ? kArrow : -kArrow;
  canvas_.open_group(title_of(wire), "link", "connection", numbers_of(wire));
  canvas_.path(way, "halo");
  canvas_.path(way, classes);
  canvas_.circle(way.front().x, way.front().y, 2.5, "head");
  canvas_.path({tip, {way.back().x, tip.y - 4}, {way.back().x, tip.y + 4}}, "head", true);
  canvas_.close_group();
}

void GraphDrawing::draw_label(const Wire& wire) {
  const Column& column = layout_.columns[wire.to.column];
  const auto put = [&](double y, std::string_view classes, const std::string& text) {
    if (wire.to.at_right) {
      canvas_.text(column.right() + 4, y, kSmall, classes, text);
    } else {
      canvas_.text_before(column.left - 4, y, kSmall, classes, text);
    }
  };
  canvas_.open_group(title_of(wire), "label", "connection", numbers_of(wire));
  put(wire.to.y - 4, "faint", label_of(cell_, wire));
  if (const auto* health = health_of(wire))
    put(wire.to.y + 12, word_of(look_of(*health)), health_text(*health));
  canvas_.close_group();
}

/// Draws the legend: explains the line styles in the drawing, and says how many devices and connections are
/// not drawn.
void GraphDrawing::draw_legend() {
  const double left = kMargin + 6;
  double y = layout_.bottom + 24;
  const auto entry = [&](std::string_view text) {
    canvas_.text(left + 52, y + 4, kSmall, "faint", text);
    y += 18;
  };
  const auto sample = [&](const std::string& classes, std::string_view text, auto holds) {
    if (std::none_of(layout_.wires.begin(), layout_.wires.end(), holds)) return;
    canvas_.line(left, y, left + 40, y, "wire " + classes);
    entry(text);
  };
  const auto of_kind = [&](ConnectionKind kind) {
    return [this, kind](const Wire& wire) { return connection_of(wire).kind == kind; };
  };
  sample("", "connection for the latest value", of_kind(ConnectionKind::latest));
  sample("queue", "connection with a queue", of_kind(ConnectionKind::queue));
  const auto with = [&](Look look) {
    return [this, look](const Wire& wire) {
      if (page_ != nullptr) return true;
      const auto* health = health_of(wire);
      return health != nullptr && look_of(*health).line == look.line;
    };
  };
  sample("good", "ok", with(kGood));
  sample("poor", "degraded: samples are being lost or dropped", with(kPoor));
  sample("bad",
         "stale: the newest value is older than the connection's deadline; or the reader gets the safe value",
         with(kBad));
  sample("broken", "not matched: the writer and the reader have not found each other", with(kBroken));
  const auto filled = [&](std::string_view classes, std::string_view text) {
    canvas_.rectangle(left + 12, y - 5, 16, 10, classes, 2);
    entry(text);
  };
  if (page_ != nullptr) {
    filled("good-word", "module: EXECUTING");
    filled("poor-word", "module: in a safe stop; device: degraded; bar: above 80 % of the budget");
    filled("bad-word", "module: in RECOVER, given up or lost; device: failed or lost; bar: above the budget");
    filled("grid-fill", "module: not EXECUTING");
    filled("used", "bar: run time (p99) as a share of the budget, else of the period or deadline");
  }
  if (cell_.devices.size() > kGraphDevices) {
    entry(fmt::format("only {} of {} devices are drawn; takt graph --json lists them all", kGraphDevices,
                      cell_.devices.size()));
  }
  if (layout_.connections_left_out > 0) {
    entry(fmt::format("{} of {} are not drawn; takt graph --json lists them all",
                      layout_.connections_left_out, count(cell_.connections.size(), "connection")));
  }
}

}  // namespace

std::string graph_svg(const model::Cell& cell, const CellHealth& health, const GraphPage* page) {
  return GraphDrawing{cell, health, page}.draw();
}

}  // namespace takt::tool
