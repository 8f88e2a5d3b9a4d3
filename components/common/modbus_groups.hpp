// Groups points into requests. One request covers adjacent points of one table, up to the size limit of a
// request. No request covers addresses between points, because a device may reject them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "modbus_map.hpp"

namespace modbus {

/// Size limits of one request, from the Modbus specification.
struct Limits {
  unsigned bits;
  unsigned registers;
};
inline constexpr Limits kReadLimits{2000, 125};
inline constexpr Limits kWriteLimits{1968, 123};

struct Group {
  Table table = Table::coil;
  std::uint16_t address = 0;
  unsigned count = 0;                 ///< number of bits or registers
  std::vector<std::size_t> points{};  ///< indexes of the points in the map, sorted by address
};

/// Returns the groups for the outputs or for the inputs. A group never splits a point. Input points may
/// share addresses; output points may not.
inline std::vector<Group> groups_of(const std::vector<Point>& points, bool out, Limits limits) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].out == out) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair{points[a].table, points[a].address} < std::pair{points[b].table, points[b].address};
  });
  std::vector<Group> groups;
  for (const std::size_t i : order) {
    const Point& point = points[i];
    const unsigned most = is_bit(point.table) ? limits.bits : limits.registers;
    if (!groups.empty()) {
      Group& last = groups.back();
      const unsigned end = std::max(last.address + last.count, point.end());
      if (last.table == point.table && point.address <= last.address + last.count &&
          end - last.address <= most) {
        last.count = end - last.address;
        last.points.push_back(i);
        continue;
      }
    }
    groups.push_back({point.table, point.address, point.width(), {i}});
  }
  return groups;
}

}  // namespace modbus
