#include <components/common/modbus_map.hpp>

#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace modbus::modbus_map_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::vector<std::string> messages(std::string_view text) {
  std::vector<std::string> lines;
  for (const Mistake& m : parse_map(text).mistakes)
    lines.push_back(std::to_string(m.line) + ": " + m.what + "; " + m.fix);
  return lines;
}

TEST(ModbusMap, ContainsThePointsOfAllLines) {
  const Map map = parse_map(R"(
    lamp         out coil 0 safe 0      # comment; with a semicolon
    button       in  discrete 3
    speed        out register 10 scale 0.001 unit m/s safe 0
    temperature  in  input-register 4 int16 scale 0.1 offset -40
    position     in  register 20 float32 order low-first ; a in coil 7;b in coil 8
  )");
  ASSERT_THAT(map.mistakes, IsEmpty());
  ASSERT_THAT(map.points, SizeIs(7));
  EXPECT_EQ(map.points[0].name, "lamp");
  EXPECT_TRUE(map.points[0].out);
  EXPECT_EQ(map.points[0].table, Table::coil);
  EXPECT_EQ(map.points[0].safe, 0.0);
  EXPECT_EQ(map.points[1].table, Table::discrete);
  EXPECT_FALSE(map.points[1].out);
  EXPECT_EQ(map.points[1].address, 3);
  EXPECT_FALSE(map.points[1].safe);
  EXPECT_EQ(map.points[2].encoding.scale, 0.001);
  EXPECT_EQ(map.points[2].unit, "m/s");
  EXPECT_EQ(map.points[3].encoding.type, Type::int16);
  EXPECT_EQ(map.points[3].encoding.offset, -40);
  EXPECT_EQ(map.points[4].encoding.type, Type::float32);
  EXPECT_TRUE(map.points[4].encoding.low_first);
  EXPECT_EQ(map.points[4].end(), 22U);
  EXPECT_EQ(map.points[6].name, "b");
}

TEST(ModbusMap, KnowsFourOrdersOfTheBytesOfAValue) {
  const Map map = parse_map(
      "a in register 0 uint32 order high-first; b in register 2 uint32 order low-first\n"
      "c in register 4 uint32 order BADC; d in register 6 uint32 order DCBA");
  ASSERT_THAT(map.points, SizeIs(4));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(map.points[i].encoding.low_first, i % 2 == 1) << i;
    EXPECT_EQ(map.points[i].encoding.bytes_swapped, i >= 2) << i;
  }
}

TEST(ModbusMap, ReportsEveryMistakeWithItsLineAndAFix) {
  const std::vector<std::string> lines = messages(
      "ok out coil 0\n"
      "1x sideways coils 65536\n"
      "\n"
      "lamp out discrete 4\n"
      "t in input-register 1 scale 0\n"
      "u in register 1 order low-first\n"
      "v out coil 0\n"
      "ok in coil 9\n"
      "w in coil 9 safe 1\n"
      "x out register 7 int16 safe 40000\n"
      "y in register 65535 uint32\n"
      "connected in coil 1\n"
      "z in\n"
      "q in coil 1 int16\n"
      "r in register 1 unit\n"
      "s in register 1 colour red\n");
  EXPECT_THAT(
      lines,
      testing::ElementsAre(
          HasSubstr("2: '1x' is not a valid port name; use up to 63 letters"),
          HasSubstr("2: 'sideways' is not a direction; write 'in'"),
          HasSubstr("2: unknown table 'coils'; write coil, discrete, register or input-register"),
          HasSubstr("2: the address cannot be '65536'; "),
          HasSubstr("4: a discrete input cannot be written; "), HasSubstr("5: the scale cannot be '0'; "),
          HasSubstr("6: only a type with two registers has a word order; "),
          HasSubstr("7: 'v' and 'ok' write the same coil; "),
          HasSubstr("8: there are two points named 'ok'; "), HasSubstr("9: an input has no safe value; "),
          HasSubstr(
              "10: the safe value does not fit the type; with this scale and offset the range is -32768 "
              "to 32767"),
          HasSubstr("11: the two registers of 'y' extend beyond address 65535; "),
          HasSubstr("12: the port name 'connected' is reserved; "),
          HasSubstr("13: 'z' is not a complete point; "), HasSubstr("14: a coil has no type; "),
          HasSubstr("15: 'unit' has no value; "), HasSubstr("16: unknown option 'colour'; "),
          HasSubstr("16: unknown option 'red'; ")));
}

TEST(ModbusMap, MustContainAPoint) {
  EXPECT_THAT(messages(""), testing::ElementsAre(HasSubstr("1: the map has no points; ")));
  EXPECT_THAT(messages("# only; words\n\n"), testing::ElementsAre(HasSubstr("the map has no points")));
}

TEST(ModbusMap, RejectsMoreThanTheMaximumNumberOfPoints) {
  std::string text;
  for (std::size_t i = 0; i < kMaxPoints; ++i)
    text += "p" + std::to_string(i) + " in coil " + std::to_string(i) + "\n";
  EXPECT_THAT(parse_map(text).mistakes, IsEmpty());
  EXPECT_THAT(messages(text + "q in coil 999\n"),
              testing::ElementsAre(HasSubstr("257: there are more than 256 points")));
}

TEST(ModbusMap, AcceptsAddressesFrom0To65535) {
  EXPECT_THAT(messages("a in coil 0; b in coil 65535; c in register 65534 float32"), IsEmpty());
  EXPECT_THAT(messages("a in coil -1"), SizeIs(1));
  EXPECT_THAT(messages("a in coil 0x10"), SizeIs(1));
}

// Whatever the text, the parser returns at least one point or one mistake, and every point is within its
// limits.
TEST(ModbusMap, NeverAcceptsInvalidPointsFromRandomText) {
  const std::vector<std::string> pieces{"lamp",     "in",
                                        "out",      "coil",
                                        "register", "input-register",
                                        "1",        "65535",
                                        "1e999",    "nan",
                                        "scale",    "safe",
                                        "order",    "low-first",
                                        "float32",  "\n",
                                        ";",        "#",
                                        "\t",       std::string{"\0\xff", 2},
                                        "unit",     "offset",
                                        "-0"};
  std::mt19937 draw{7};
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    for (auto n = draw() % 24; n > 0; --n)
      text += pieces[draw() % pieces.size()] + (draw() % 5 != 0 ? " " : "");
    const Map map = parse_map(text);
    ASSERT_TRUE(!map.points.empty() || !map.mistakes.empty()) << text;
    for (const Point& point : map.points) {
      ASSERT_LE(point.end(), 65536U) << text;
      ASSERT_TRUE(std::isfinite(point.encoding.scale) && point.encoding.scale != 0) << text;
      ASSERT_TRUE(!point.out || point.table == Table::coil || point.table == Table::holding) << text;
    }
  }
}

TEST(ModbusMap, RejectsControlCharactersInAUnit) {
  EXPECT_TRUE(parse_map("a in register 1 unit \xC2\xB0"
                        "C")
                  .mistakes.empty());
  for (const char* unit : {"\x1b[2J", "m\x7f", "\x01"}) {
    const Map map = parse_map(std::string{"a in register 1 unit "} + unit);
    ASSERT_EQ(map.mistakes.size(), 1U);
    EXPECT_NE(map.mistakes[0].what.find("contains control characters"), std::string::npos);
  }
}

TEST(ModbusMap, StopsAtTheMaximumNumberOfMistakesEvenWithinOneLine) {
  std::string text = "a in register 1";
  for (int i = 0; i < 10000; ++i) text += " x";
  EXPECT_EQ(parse_map(text).mistakes.size(), kMostMistakes);
}

}  // namespace
}  // namespace modbus::modbus_map_test
