// The layout of a cell's graph. Each device is a column of boxes, one box per module. Between two columns is
// a channel for connections: a connection leaves its port sideways, goes up or down on its own track, and
// enters the other port sideways. A connection that passes a device goes below all columns. The connections
// of one output leave it on one line. So no lines of different outputs overlap, no line crosses a box, and no
// two texts overlap.
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <takt/model/cell.hpp>

#include "drawing/canvas.hpp"
#include "reports/graph_report.hpp"

namespace takt::tool::graph {

// The sizes below are in pixels.
inline constexpr double kTop = 70;        ///< y coordinate of the first column
inline constexpr double kTopOnPage = 40;  ///< likewise on a page, which shows the name of the cell itself
inline constexpr double kInside = 12;     ///< distance from a frame to its content
inline constexpr double kArrow = 8;       ///< length of an arrow head
inline constexpr double kMeasures = 40;   ///< height of the measurements in the box of a module, on a page
inline constexpr double kRoomForMeasures =
    170;                             ///< minimum width of the facts in the box of a module, on a page
inline constexpr double kFold = 24;  ///< size of the control that collapses a device, on a page

/// The CSS classes that show a state.
struct Look {
  std::string_view line;  ///< class of the connection's line
  std::string_view word;  ///< class of the word that names the state
};
inline constexpr Look kUnknown{"", "faint"};
inline constexpr Look kGood{"good", "good-word"};
inline constexpr Look kPoor{"poor", "poor-word"};
inline constexpr Look kBad{"bad", "bad-word"};
inline constexpr Look kBroken{"broken", "bad-word"};
Look look_of(const CellHealth::Connection& health);

/// The label at the arrow of a connection, which has the connection's most important properties.
std::string label_of(const model::Connection& connection);

struct Port {
  std::string name;
  bool input = false;
  std::vector<std::size_t> left;   ///< the indexes of the wires on the left side, from top to bottom
  std::vector<std::size_t> right;  ///< the indexes of the wires on the right side, from top to bottom
  double y = 0;  ///< y of the name and the first wire; each further wire of an input is `pitch` lower

  [[nodiscard]] std::size_t lines() const;
  /// True if the port stands beside the facts of its module, which are at the left of the box. Any other port
  /// is below them.
  [[nodiscard]] bool beside_facts() const { return left.empty(); }
  /// True if the drawing shows the port's name at the right edge of the box, not at the left edge.
  [[nodiscard]] bool named_at_right() const {
    return left.empty() ? !right.empty() || !input : !right.empty() && !input;
  }
};

/// The box of a module, or of a topic that programs outside Takt use.
struct Box {
  std::string name;
  std::string about;
  std::string state;
  Look look = kUnknown;
  std::string title;  ///< the tooltip, which has all details
  std::vector<Port> ports;
  double top = 0;
  double height = 0;
};

/// The column of a device, or of all programs outside Takt.
struct Column {
  std::string name;
  std::string about;
  std::string state;
  Look look = kUnknown;
  bool outside = false;
  bool collapsed = false;
  std::size_t left_out = 0;  ///< the number of modules that are not drawn
  std::vector<Box> boxes;
  double left = 0;
  double width = 0;
  double top = 0;
  double bottom = 0;

  [[nodiscard]] double right() const { return left + width; }
};

/// One end of a wire: the port where it begins or ends.
struct WireEnd {
  std::size_t column = 0;
  std::size_t box = 0;
  std::size_t port = 0;
  bool at_right = false;
  double y = 0;
};

struct Wire {
  std::vector<std::size_t>
      connections{};  ///< the indexes in Cell::connections; several only at a collapsed device
  WireEnd from;
  WireEnd to;
  std::vector<Point> way;  ///< the corners of the line, from port to port
  bool branches = false;   ///< true if another wire of the output goes on where this one turns
};

/// The label of a wire: that of its connection, or how many connections it stands for.
std::string label_of(const model::Cell& cell, const Wire& wire);

struct Layout {
  std::vector<Column> columns;
  std::vector<Wire> wires;
  double bottom = 0;  ///< y coordinate of the graph's lower edge
  double pitch = 0;   ///< distance of two neighbouring wires of one port
  std::size_t connections_left_out = 0;
};

Layout lay_out(const model::Cell& cell, const CellHealth& health, const GraphPage* page = nullptr);

}  // namespace takt::tool::graph
