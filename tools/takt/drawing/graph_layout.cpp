#include "drawing/graph_layout.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "reports/connections_report.hpp"
#include "reports/run_report.hpp"

namespace takt::tool::graph {
namespace {

using model::Connection;
using model::Module;

// The sizes below are in pixels.
constexpr double kTrack = 12;  // distance of two neighbouring tracks
constexpr double kStub = 18;   // minimum distance from a column to the first track

/// The vertical distance of two neighbouring wires, each with a label. kPitchLive is for a running cell,
/// whose drawing also shows the health of each connection below the label.
constexpr double kPitchAtRest = 20;
constexpr double kPitchLive = 32;
/// All y coordinates are multiples of this step. Every second column is half a step lower, so that wires from
/// the two columns beside a channel never have the same y. kStepLive is the step for a running cell.
constexpr double kStepAtRest = 20;
constexpr double kStepLive = 16;

Look look_of(wire::Rating rating) {
  switch (rating) {
    case wire::Rating::good:
      return kGood;
    case wire::Rating::idle:
      return kUnknown;
    case wire::Rating::poor:
      return kPoor;
    case wire::Rating::bad:
      return kBad;
    case wire::Rating::broken:
      return kBroken;
  }
  return kUnknown;
}

/// Replaces the middle of a long text with "...".
std::string shortened(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  return text.substr(0, most / 2) + "..." + text.substr(text.size() - (most - most / 2 - 3));
}

/// The vertical part of a wire, in a channel.
struct Track {
  std::size_t wire = 0;
  double from = 0;            // the y coordinate at which the track begins
  double to = 0;              // the y coordinate at which the track ends
  bool leaves_left = false;   // the wire ends at the column on the left of the channel
  bool leaves_right = false;  // the wire ends at the column on the right of the channel
  std::size_t place = 0;      // tracks that are not beside each other may have the same place
  double x = 0;

  [[nodiscard]] bool beside(const Track& other) const {
    return std::min(from, to) <= std::max(other.from, other.to) &&
           std::min(other.from, other.to) <= std::max(from, to);
  }
};

/// The space between a column and the next one, for vertical parts of wires and for labels.
struct Channel {
  double left_zone = kStub;  // width of the labels at the left column
  double right_zone = kStub;
  std::vector<Track> tracks;
  std::size_t places = 0;

  [[nodiscard]] double width() const {
    return tracks.empty() ? 2 * kMargin : left_zone + right_zone + kTrack * static_cast<double>(places + 1);
  }
};

/// The index of the channel beside the port at this end of a wire.
std::size_t channel_of(const WireEnd& place) { return place.at_right ? place.column : place.column - 1; }

/// True if the wire passes a whole column. Such a wire is drawn below all columns.
bool passes(const Wire& wire) {
  return wire.from.column > wire.to.column + 1 || wire.to.column > wire.from.column + 1;
}

class Builder {
 public:
  Builder(const model::Cell& cell, const CellHealth& health, const GraphPage* page)
      : cell_(cell), health_(health), page_(page) {
    const bool live = !health.connections.empty();
    layout_.pitch = live ? kPitchLive : kPitchAtRest;
    step_ = live ? kStepLive : kStepAtRest;
  }

  Layout build() {
    for (std::size_t i = 0; i < std::min(cell_.devices.size(), kGraphDevices); ++i)
      add_device(cell_.devices[i]);
    add_wires();
    for (Column& column : layout_.columns) {
      for (Box& box : column.boxes) inputs_first(box);
    }
    name_places();
    choose_sides();
    set_heights();
    set_widths();
    find_ways();
    return std::move(layout_);
  }

 private:
  using Key = std::tuple<std::size_t, std::size_t, std::string>;
  /// Identifies a port by name. Indexes are valid only after all ports have been added and sorted.
  struct Named {
    WireEnd place;
    std::string port;
    bool input = false;

    [[nodiscard]] Key key() const { return {place.column, place.box, port}; }
  };

  void add_device(const model::Device& device);
  Box box_of(const model::Device& device, const Module& module, bool alive) const;
  Column& outside();
  Named end_of(const model::Endpoint& end, const model::Endpoint& other, const Connection& connection,
               bool input);
  [[nodiscard]] bool is_collapsed(const std::string& device) const {
    return page_ != nullptr && page_->collapsed.contains(device);
  }
  void add_wires();
  static void inputs_first(Box& box);
  void name_places();
  void choose_sides();
  void set_heights();
  void set_heights(Column& column);
  [[nodiscard]] bool measured(const Box& box) const { return page_ != nullptr && !box.state.empty(); }
  void set_widths();
  void add_tracks(std::size_t wire);
  static void order(Channel& channel);
  static void pack(Channel& channel);
  void find_ways();
  [[nodiscard]] double x_of(const WireEnd& place, std::size_t wire) const;

  Port& port_at(const WireEnd& place) {
    return layout_.columns[place.column].boxes[place.box].ports[place.port];
  }
  [[nodiscard]] double whole(double height) const { return std::ceil(height / step_) * step_; }

  const model::Cell& cell_;
  const CellHealth& health_;
  const GraphPage* page_;
  double step_;
  Layout layout_;
  std::map<std::string, WireEnd> modules_;              // for each module, by "device.module"
  std::map<std::string, std::size_t> topics_;           // the index of each topic's box in outside()
  std::vector<std::pair<Named, Named>> ends_;           // the two ends of each wire
  std::map<std::pair<Key, Key>, std::size_t> bundles_;  // the index of each wire of a collapsed device
  std::vector<Channel> channels_;
};

Box Builder::box_of(const model::Device& device, const Module& module, bool alive) const {
  const std::string path = device.name + "." + module.name;
  Box box;
  box.name = module.name;
  box.about = std::string{model::to_text(module.type)} + ", " + operation_text(module);
  box.title = path + ": " + box.about + fmt::format(", priority {}", module.priority) +
              (module.executor.empty() ? "" : ", executor " + module.executor) +
              (module.budget ? ", budget " + to_text(*module.budget) : "");
  if (const auto state = health_.modules.find(path); state != health_.modules.end()) {
    box.state = alive ? state->second : lost_text(state->second);
    box.look = look_of(wire::judge(wire::ModuleReport{.state = state->second,
                                                      .lost = !alive,
                                                      .given_up = health_.given_up.contains(path),
                                                      .safe_stop = health_.safe_stops.contains(path)}));
    box.title += "; " + box.state;
  }
  return box;
}

void Builder::add_device(const model::Device& device) {
  Column column;
  column.name = device.name;
  column.about = count(device.modules.size(), "module");
  bool alive = true;
  if (const auto known = health_.devices.find(device.name); known != health_.devices.end()) {
    const std::string& why = known->second.text;
    alive = known->second.alive;
    column.state = (alive ? "alive" : "LOST") + (why.empty() ? "" : ", " + shortened(why, 40));
    column.look = look_of(wire::judge(
        wire::DeviceReport{.state = "running", .health = why.empty() ? "ok" : "degraded", .alive = alive}));
  }
  column.collapsed = is_collapsed(device.name);
  for (const Module& module : device.modules) {
    if (column.collapsed) {
      modules_[device.name + "." + module.name] = {.column = layout_.columns.size()};
      continue;
    }
    if (column.boxes.size() == kGraphModules) break;
    modules_[device.name + "." + module.name] = {.column = layout_.columns.size(),
                                                 .box = column.boxes.size()};
    column.boxes.push_back(box_of(device, module, alive));
  }
  if (column.collapsed)
    column.boxes.emplace_back();
  else
    column.left_out = device.modules.size() - column.boxes.size();
  layout_.columns.push_back(std::move(column));
}

/// The last column, for programs outside Takt. The first call creates it.
Column& Builder::outside() {
  if (layout_.columns.empty() || !layout_.columns.back().outside) {
    Column& column = layout_.columns.emplace_back();
    column.name = "other programs";
    column.outside = true;
  }
  return layout_.columns.back();
}

Builder::Named Builder::end_of(const model::Endpoint& end, const model::Endpoint& other,
                               const Connection& connection, bool input) {
  if (end.given()) {
    const WireEnd place = modules_.at(end.device + "." + end.module);
    if (!is_collapsed(end.device)) return {place, end.port, input};
    return {place, (input ? "from " : "to ") + (other.given() ? other.device : "other programs"), input};
  }
  Column& column = outside();
  const std::string domain = connection.domain ? fmt::format("domain {}", *connection.domain) : "";
  const auto [topic, is_new] = topics_.emplace(connection.topic + " " + domain, column.boxes.size());
  if (is_new) {
    Box& box = column.boxes.emplace_back();
    box.name = shortened(connection.topic, 48);
    box.about = domain.empty() ? "topic" : "topic, " + domain;
    box.title = "topic " + connection.topic + (domain.empty() ? "" : ", " + domain);
  }
  const WireEnd place{.column = layout_.columns.size() - 1, .box = topic->second};
  return {place, input ? "read" : "written", input};
}

void Builder::add_wires() {
  const auto drawn = [&](const model::Endpoint& end) {
    return !end.given() || modules_.count(end.device + "." + end.module) > 0;
  };
  for (std::size_t i = 0; i < cell_.connections.size(); ++i) {
    const Connection& connection = cell_.connections[i];
    if (layout_.wires.size() == kGraphConnections || !drawn(connection.from) || !drawn(connection.to)) {
      ++layout_.connections_left_out;
      continue;
    }
    const auto is_folded = [&](const model::Endpoint& end) {
      return end.given() && is_collapsed(end.device);
    };
    if (is_folded(connection.from) && connection.from.device == connection.to.device) continue;
    auto from = end_of(connection.from, connection.to, connection, false);
    auto to = end_of(connection.to, connection.from, connection, true);
    if (is_folded(connection.from) || is_folded(connection.to)) {
      const auto [known, is_new] = bundles_.try_emplace({from.key(), to.key()}, layout_.wires.size());
      if (!is_new) {
        layout_.wires[known->second].connections.push_back(i);
        continue;
      }
    }
    Wire wire;
    wire.connections.push_back(i);
    layout_.wires.push_back(std::move(wire));
    ends_.emplace_back(std::move(from), std::move(to));
    for (const Named* end : {&ends_.back().first, &ends_.back().second}) {
      std::vector<Port>& ports = layout_.columns[end->place.column].boxes[end->place.box].ports;
      const bool known = std::any_of(ports.begin(), ports.end(), [&](const Port& port) {
        return port.name == end->port && port.input == end->input;
      });
      if (known) continue;
      ports.emplace_back();
      ports.back().name = end->port;
      ports.back().input = end->input;
    }
  }
}

/// Moves the inputs of a module before its outputs. Apart from that, the ports keep the order in which the
/// connections mention them.
void Builder::inputs_first(Box& box) {
  std::stable_partition(box.ports.begin(), box.ports.end(), [](const Port& port) { return port.input; });
}

void Builder::name_places() {
  const auto place_of = [&](const Named& end) {
    WireEnd place = end.place;
    while (port_at(place).name != end.port || port_at(place).input != end.input) ++place.port;
    return place;
  };
  for (std::size_t i = 0; i < layout_.wires.size(); ++i) {
    layout_.wires[i].from = place_of(ends_[i].first);
    layout_.wires[i].to = place_of(ends_[i].second);
  }
}

/// Chooses on which side of its two ports each wire begins and ends: the side that faces the other port. A
/// wire within a device uses the right side.
void Builder::choose_sides() {
  for (std::size_t i = 0; i < layout_.wires.size(); ++i) {
    Wire& wire = layout_.wires[i];
    wire.from.at_right = wire.to.column >= wire.from.column;
    wire.to.at_right = wire.to.column <= wire.from.column;
    for (const WireEnd* place : {&wire.from, &wire.to}) {
      (place->at_right ? port_at(*place).right : port_at(*place).left).push_back(i);
    }
  }
}

void Builder::set_heights(Column& column) {
  double y = column.top + whole(column.state.empty() ? 40 : 54);
  for (Box& box : column.boxes) {
    box.top = y;
    const auto put = [&](Port& port, double& at) {
      port.y = at + layout_.pitch / 2;
      at += layout_.pitch * static_cast<double>(port.lines());
    };
    double beside = y;
    if (!column.collapsed) y += whole((box.state.empty() ? 34 : 46) + (measured(box) ? kMeasures : 0));
    for (Port& port : box.ports) {
      if (port.beside_facts()) put(port, beside);
    }
    for (Port& port : box.ports) {
      if (port.right.empty()) put(port, y);
    }
    y = std::max(y, beside);
    for (Port& port : box.ports) {
      if (!port.beside_facts() && !port.right.empty()) put(port, y);
    }
    box.height = whole(y - box.top);
    y = box.top + box.height + step_;
  }
  if (column.left_out > 0) y += step_;
  column.bottom = y;
}

void Builder::set_heights() {
  std::vector<Column>& columns = layout_.columns;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    columns[c].top = (page_ == nullptr ? kTop : kTopOnPage) + (c % 2 == 1 ? step_ / 2 : 0);
    set_heights(columns[c]);
    layout_.bottom = std::max(layout_.bottom, columns[c].bottom);
  }
  for (std::size_t i = 0; i < layout_.wires.size(); ++i) {
    for (WireEnd* place : {&layout_.wires[i].from, &layout_.wires[i].to}) {
      const Port& port = port_at(*place);
      const auto& side = place->at_right ? port.right : port.left;
      const auto at = port.input ? std::find(side.begin(), side.end(), i) - side.begin() : 0;
      place->y = port.y + layout_.pitch * static_cast<double>(at);
    }
  }
}

/// Adds the tracks of a wire. A wire within a device or to the next device has one track. A wire that passes
/// a device has two tracks, and between them a horizontal line below all columns.
void Builder::add_tracks(std::size_t index) {
  const Wire& wire = layout_.wires[index];
  if (passes(wire)) {
    for (const WireEnd* place : {&wire.from, &wire.to}) {
      channels_[channel_of(*place)].tracks.push_back({.wire = index,
                                                      .from = place->y,
                                                      .to = layout_.bottom,
                                                      .leaves_left = place->at_right,
                                                      .leaves_right = !place->at_right});
    }
    return;
  }
  const bool to_the_left = !wire.from.at_right;
  channels_[channel_of(wire.from)].tracks.push_back(
      {.wire = index,
       .from = to_the_left ? wire.to.y : wire.from.y,
       .to = to_the_left ? wire.from.y : wire.to.y,
       .leaves_left = wire.from.at_right || wire.to.at_right,
       .leaves_right = !wire.from.at_right || !wire.to.at_right});
}

/// Orders the tracks of a channel from left to right, so that few wires cross. Wires that return to their
/// column, or go below all columns, stay near their column, the shortest ones nearest. The other wires run
/// between them: first those that go down to the right, the lowest first; then those that go up, the highest
/// first.
void Builder::order(Channel& channel) {
  const auto rank = [](const Track& track) { return !track.leaves_right ? 0 : track.leaves_left ? 1 : 2; };
  const auto length = [](const Track& track) { return std::abs(track.to - track.from); };
  std::stable_sort(channel.tracks.begin(), channel.tracks.end(), [&](const Track& a, const Track& b) {
    if (rank(a) != rank(b)) return rank(a) < rank(b);
    if (rank(a) == 0) return length(a) < length(b);
    if (rank(a) == 2) return length(a) > length(b);
    const bool a_down = a.to > a.from;
    const bool b_down = b.to > b.from;
    if (a_down != b_down) return a_down;
    return a_down ? a.from > b.from : a.from < b.from;
  });
}

/// Gives the tracks places from left to right, as few as possible, in an order that order() has chosen. Only
/// tracks beside each other need different places, and only their order affects which wires cross. Tracks of
/// wires that return to the right column stay near it.
void Builder::pack(Channel& channel) {
  std::vector<Track>& tracks = channel.tracks;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    for (std::size_t u = 0; u < t; ++u) {
      if (tracks[t].beside(tracks[u])) tracks[t].place = std::max(tracks[t].place, tracks[u].place + 1);
    }
    channel.places = std::max(channel.places, tracks[t].place + 1);
  }
  for (std::size_t t = tracks.size(); t-- > 0 && !tracks[t].leaves_left;) {
    tracks[t].place = channel.places - 1;
    for (std::size_t u = t + 1; u < tracks.size(); ++u) {
      if (tracks[t].beside(tracks[u])) tracks[t].place = std::min(tracks[t].place, tracks[u].place - 1);
    }
  }
}

void Builder::set_widths() {
  channels_.resize(layout_.columns.size());
  for (std::size_t i = 0; i < layout_.wires.size(); ++i) {
    add_tracks(i);
    const Wire& wire = layout_.wires[i];
    const auto health = health_.connections.find(wire.connections.front());
    double room = width_of(label_of(cell_, wire), kSmall);
    if (health != health_.connections.end())
      room = std::max(room, width_of(health_text(health->second), kSmall));
    Channel& channel = channels_[channel_of(wire.to)];
    double& zone = wire.to.at_right ? channel.left_zone : channel.right_zone;
    zone = std::max(zone, room + 8);
  }
  double x = kMargin;
  for (std::size_t c = 0; c < layout_.columns.size(); ++c) {
    Column& column = layout_.columns[c];
    double widest = std::max(width_of(column.name, kLarge) + (page_ == nullptr || column.outside ? 0 : kFold),
                             width_of(column.state, kSmall));
    double facts = 0;
    double beside = 0;  // the widest port beside the facts
    for (const Box& box : column.boxes) {
      facts = std::max({facts, measured(box) ? kRoomForMeasures : 0, width_of(box.name, kNormal),
                        width_of(box.about, kSmall), width_of(box.state, kSmall)});
      for (const Port& port : box.ports) {
        const double width = width_of(port.name, kSmall);
        widest = std::max(widest, width + 3 * kInside);
        if (port.beside_facts()) beside = std::max(beside, width + 2 * kInside);
        if (port.right.empty()) facts = std::max(facts, width);
      }
    }
    widest = std::max(widest, facts + kInside + beside);
    column.left = x;
    column.width = std::ceil(widest + 2 * kInside);
    Channel& channel = channels_[c];
    order(channel);
    pack(channel);
    for (Track& track : channel.tracks)
      track.x = column.right() + channel.left_zone + kTrack * static_cast<double>(track.place + 1);
    x = column.right() + channel.width();
  }
}

double Builder::x_of(const WireEnd& place, std::size_t wire) const {
  const std::vector<Track>& tracks = channels_[channel_of(place)].tracks;
  return std::find_if(tracks.begin(), tracks.end(), [&](const Track& track) { return track.wire == wire; })
      ->x;
}

void Builder::find_ways() {
  const auto edge = [&](const WireEnd& place) {
    const Column& column = layout_.columns[place.column];
    return place.at_right ? column.right() - kInside : column.left + kInside;
  };
  for (std::size_t i = 0; i < layout_.wires.size(); ++i) {
    Wire& wire = layout_.wires[i];
    const double first = x_of(wire.from, i);
    const double last = x_of(wire.to, i);
    wire.way = {{edge(wire.from), wire.from.y}, {first, wire.from.y}};
    if (passes(wire)) {
      layout_.bottom += kTrack;
      wire.way.push_back({first, layout_.bottom});
      wire.way.push_back({last, layout_.bottom});
    }
    wire.way.push_back({last, wire.to.y});
    wire.way.push_back({edge(wire.to), wire.to.y});
  }
  for (std::size_t i = 0; i < layout_.wires.size(); ++i) {
    Wire& wire = layout_.wires[i];
    const Port& port = port_at(wire.from);
    for (const std::size_t other : wire.from.at_right ? port.right : port.left) {
      const double further = layout_.wires[other].way[1].x - wire.way[1].x;
      if (other != i && (wire.from.at_right ? further >= 0 : further <= 0)) wire.branches = true;
    }
  }
}

}  // namespace

std::size_t Port::lines() const { return input ? std::max<std::size_t>({left.size(), right.size(), 1}) : 1; }

Look look_of(const CellHealth::Connection& health) { return look_of(wire::judge(health).rating); }

std::string label_of(const Connection& connection) {
  std::string text = kind_text(connection);
  const bool queue = connection.kind == model::ConnectionKind::queue;
  const bool reliable = connection.reliability == model::Reliability::reliable;
  if (queue != reliable) text += std::string{", "} + model::to_text(connection.reliability);
  if (connection.deadline) text += ", stale after " + to_text(*connection.deadline);
  if (connection.stale == model::Stale::error) text += ": error";
  return text;
}

std::string label_of(const model::Cell& cell, const Wire& wire) {
  if (wire.connections.size() > 1) return count(wire.connections.size(), "connection");
  return label_of(cell.connections[wire.connections.front()]);
}

Layout lay_out(const model::Cell& cell, const CellHealth& health, const GraphPage* page) {
  return Builder{cell, health, page}.build();
}

}  // namespace takt::tool::graph
