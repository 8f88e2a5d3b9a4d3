// Where everything of a cell's graph stands. Devices stand side by side, their modules below each other, and
// between two devices is a channel for what goes from port to port: each connection leaves its port sideways,
// goes up or down on a track of its own, and enters the other port sideways. What goes past a device goes
// below all of them. So no two lines ever lie on each other, no line crosses a box, and every word has its
// place for itself.
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
inline constexpr double kTop = 70;     ///< of the first column
inline constexpr double kInside = 12;  ///< from a frame to what is in it
inline constexpr double kArrow = 8;    ///< its head

/// How a state is drawn, beside the word for it: classes of the picture.
struct Look {
  std::string_view line;  ///< of a connection
  std::string_view word;
};
inline constexpr Look kUnknown{"", "faint"};
inline constexpr Look kGood{"good", "good-word"};
inline constexpr Look kPoor{"poor", "poor-word"};
inline constexpr Look kBad{"bad", "bad-word"};
inline constexpr Look kBroken{"broken", "bad-word"};
Look look_of(const CellHealth::Connection& health);

/// What stands at the arrow: what a reader of the picture asks first.
std::string label_of(const model::Connection& connection);

struct Port {
  std::string name;
  bool input = false;
  std::vector<std::size_t> left;  ///< wires that go to this side, from above
  std::vector<std::size_t> right;
  double y = 0;  ///< of its name and of the first of them; the others are a pitch apart

  [[nodiscard]] std::size_t lines() const;
  /// Its name stands where its wires are.
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
  std::string title;  ///< everything, for who points at it
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
  std::size_t left_out = 0;  ///< modules
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
  std::vector<Point> way;  ///< from port to port
};

struct Layout {
  std::vector<Column> columns;
  std::vector<Wire> wires;
  double bottom = 0;  ///< of all of it
  double pitch = 0;   ///< between two wires of one port
  std::size_t connections_left_out = 0;
};

Layout lay_out(const model::Cell& cell, const CellHealth& health);

}  // namespace takt::tool::graph
