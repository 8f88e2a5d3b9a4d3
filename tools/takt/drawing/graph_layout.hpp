// The layout of a cell's graph. Devices are columns, with their modules as boxes below each other. Between
// two columns is a channel for the connections: each connection leaves its port sideways, goes up or down on
// its own track, and enters the other port sideways. A connection that passes a device goes below all
// columns. So no two lines overlap, no line crosses a box, and no two texts overlap.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <takt/model/cell.hpp>

#include "drawing/canvas.hpp"
#include "reports/graph_report.hpp"

namespace takt::tool::graph {

// Pixels.
inline constexpr double kTop = 70;     ///< y of the first column
inline constexpr double kInside = 12;  ///< from a frame to its content
inline constexpr double kArrow = 8;    ///< length of an arrow head

/// The CSS classes for a state.
struct Look {
  std::string_view line;  ///< of the line of a connection
  std::string_view word;  ///< of the word for the state
};
inline constexpr Look kUnknown{"", "faint"};
inline constexpr Look kGood{"good", "good-word"};
inline constexpr Look kPoor{"poor", "poor-word"};
inline constexpr Look kBad{"bad", "bad-word"};
inline constexpr Look kBroken{"broken", "bad-word"};
Look look_of(const CellHealth::Connection& health);

/// The label at the arrow of a connection: its most important properties.
std::string label_of(const model::Connection& connection);

struct Port {
  std::string name;
  bool input = false;
  std::vector<std::size_t> left;   ///< wires on the left side, from top to bottom
  std::vector<std::size_t> right;  ///< wires on the right side
  double y = 0;                    ///< of its name and its first wire; the other wires follow at the pitch

  [[nodiscard]] std::size_t lines() const;
  /// The name is on the side of the wires.
  [[nodiscard]] bool named_at_right() const {
    return left.empty() ? !right.empty() || !input : !right.empty() && !input;
  }
};

/// A module, or a topic of other programs.
struct Box {
  std::string name;
  std::string about;
  std::string state;
  Look look = kUnknown;
  std::string title;  ///< tooltip with all details
  std::vector<Port> ports;
  double top = 0;
  double height = 0;
};

/// A device, or all other programs.
struct Column {
  std::string name;
  std::string about;
  std::string state;
  Look look = kUnknown;
  bool outside = false;
  std::size_t left_out = 0;  ///< modules that are not drawn
  std::vector<Box> boxes;
  double left = 0;
  double width = 0;
  double top = 0;
  double bottom = 0;

  [[nodiscard]] double right() const { return left + width; }
};

/// One end of a wire.
struct Place {
  std::size_t column = 0;
  std::size_t box = 0;
  std::size_t port = 0;
  bool at_right = false;
  double y = 0;
};

struct Wire {
  std::size_t connection = 0;  ///< index in Cell::connections
  Place from;
  Place to;
  std::vector<Point> way;  ///< the corners of the line, from port to port
};

struct Layout {
  std::vector<Column> columns;
  std::vector<Wire> wires;
  double bottom = 0;  ///< of the whole graph
  double pitch = 0;   ///< distance of two wires of one port
  std::size_t connections_left_out = 0;
};

Layout lay_out(const model::Cell& cell, const CellHealth& health);

}  // namespace takt::tool::graph
