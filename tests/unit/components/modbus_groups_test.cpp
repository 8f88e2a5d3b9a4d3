#include <components/common/modbus_groups.hpp>

#include <string>

#include <gtest/gtest.h>

namespace modbus::modbus_groups_test {
namespace {

std::string text(const std::vector<Group>& groups) {
  std::string result;
  for (const Group& group : groups) {
    result += std::string{to_text(group.table)} + " " + std::to_string(group.address) + "+" +
              std::to_string(group.count) + ":";
    for (const std::size_t i : group.points) result += " " + std::to_string(i);
    result += "\n";
  }
  return result;
}

std::vector<Point> points(std::string_view map) {
  Map parsed = parse_map(map);
  EXPECT_TRUE(parsed.mistakes.empty());
  return parsed.points;
}

TEST(ModbusGroups, CombineAdjacentPointsOfOneTable) {
  const auto map =
      points("a in coil 2; b in coil 0; c in coil 1; d in coil 4; e in discrete 5; f out coil 3");
  EXPECT_EQ(text(groups_of(map, false, kReadLimits)), "coil 0+3: 1 2 0\ncoil 4+1: 3\ndiscrete 5+1: 4\n");
  EXPECT_EQ(text(groups_of(map, true, kWriteLimits)), "coil 3+1: 5\n");
}

TEST(ModbusGroups, IncludeBothRegistersOfA32BitValue) {
  EXPECT_EQ(text(groups_of(points("a in register 0 float32; b in register 2; c in register 4"), false,
                           kReadLimits)),
            "register 0+3: 0 1\nregister 4+1: 2\n");
}

TEST(ModbusGroups, ReadOverlappingPointsOnce) {
  EXPECT_EQ(text(groups_of(points("a in register 0 float32; b in register 0; c in register 1 uint32"), false,
                           kReadLimits)),
            "register 0+3: 0 1 2\n");
  // Point b uses the second of the two registers of point a.
  EXPECT_EQ(
      text(groups_of(points("a in register 0 uint32; b in register 1; c in register 2"), false, kReadLimits)),
      "register 0+3: 0 1 2\n");
}

TEST(ModbusGroups, StayWithinTheRequestLimitWithoutSplittingAPoint) {
  const auto map = points("a in register 0 uint32; b in register 2 uint32; c in register 4 uint32");
  EXPECT_EQ(text(groups_of(map, false, {.bits = 8, .registers = 5})), "register 0+4: 0 1\nregister 4+2: 2\n");
  EXPECT_EQ(text(groups_of(map, false, {.bits = 8, .registers = 6})), "register 0+6: 0 1 2\n");
}

TEST(ModbusGroups, MayIncludeTheHighestAddress) {
  EXPECT_EQ(text(groups_of(points("a in coil 65534; b in coil 65535"), false, kReadLimits)),
            "coil 65534+2: 0 1\n");
}

}  // namespace
}  // namespace modbus::modbus_groups_test
