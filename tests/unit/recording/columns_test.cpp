#include <takt/recording/columns.hpp>

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <takt/client/port_names.hpp>
#include <takt/recording/csv.hpp>

namespace takt::recording::columns_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

model::Type type_of(const std::string& fields) {
  const auto type = model::parse_type(R"({"name":"t::T","fields":[)" + fields + "]}");
  EXPECT_TRUE(type) << to_text(type.problems());
  return *type;
}

const std::string kAll = R"({"name":"mode","type":"enum","of":"t::Mode","enumerators":["OFF","ON"]},)"
                         R"({"name":"label","type":"string","bound":15},)"
                         R"({"name":"grid","type":"double","array":[2,2]},)"
                         R"({"name":"way","type":"float","sequence":3},)"
                         R"({"name":"poses","type":"struct","of":"t::Pose","sequence":2,"fields":[)"
                         R"({"name":"x","type":"long"},{"name":"on","type":"boolean"}]},)"
                         R"({"name":"large","type":"unsigned long long"})";

std::vector<std::string> names(const Columns& columns) {
  std::vector<std::string> names;
  for (const Column& column : columns.all()) names.push_back(column.name);
  return names;
}

std::vector<std::string> texts(const Columns& columns, const model::Type& type, const std::string& json) {
  const auto bytes = model::sample_bytes(type, json);
  EXPECT_TRUE(bytes) << to_text(bytes.problems());
  std::vector<Value> values;
  columns.values(bytes->data(), bytes->size(), values);
  std::vector<std::string> texts;
  for (const Value& value : values) texts.push_back(value.text());
  return texts;
}

TEST(Columns, HaveANameForEveryElementOfASample) {
  const Columns columns{type_of(kAll)};
  EXPECT_THAT(names(columns), ElementsAre("mode", "label", "grid[0][0]", "grid[0][1]", "grid[1][0]",
                                          "grid[1][1]", "way[0]", "way[1]", "way[2]", "poses[0].x",
                                          "poses[0].on", "poses[1].x", "poses[1].on", "large"));
  EXPECT_FALSE(columns.fixed());
  EXPECT_TRUE(Columns{type_of(R"({"name":"a","type":"double","array":[2]})")}.fixed());
}

TEST(Columns, HaveTheUnitsOfTheirFields) {
  const Columns columns{type_of(R"({"name":"p","type":"struct","of":"t::P","array":[2],"fields":[)"
                                R"({"name":"x","type":"double","unit":"m"},{"name":"n","type":"long"}]})")};
  std::vector<std::string> units;
  for (const Column& column : columns.all()) units.push_back(column.unit);
  EXPECT_THAT(units, ElementsAre("m", "", "m", ""));
}

TEST(Columns, ContainTheTextOfEachValueInOrder) {
  const auto type = type_of(kAll);
  const Columns columns{type};
  EXPECT_THAT(texts(columns, type,
                    R"({"mode":"ON","label":"a,b","grid":[[1,2.5],[-3,1e300]],"way":[0.1,0.2],)"
                    R"("poses":[{"x":-7,"on":true}],"large":18446744073709551615})"),
              ElementsAre("ON", "a,b", "1", "2.5", "-3", "1e+300", "0.1", "0.2", "", "-7", "true", "", "",
                          "18446744073709551615"));
}

TEST(Columns, AreFoundByFieldSubfieldAndElement) {
  const Columns columns{type_of(kAll)};
  EXPECT_THAT(columns.named("mode"), ElementsAre(0));
  EXPECT_THAT(columns.named("grid"), ElementsAre(2, 3, 4, 5));
  EXPECT_THAT(columns.named("grid[1]"), ElementsAre(4, 5));
  EXPECT_THAT(columns.named("poses[1]"), ElementsAre(11, 12));
  EXPECT_THAT(columns.named("poses.x"), ElementsAre(9, 11));
  EXPECT_THAT(columns.named("gri"), IsEmpty());
  EXPECT_EQ(14U, columns.named("").size());
}

TEST(Columns, ConvertValuesToNumbersForACurve) {
  const auto type = type_of(kAll);
  const Columns columns{type};
  const auto bytes = model::sample_bytes(type, R"({"mode":"ON","grid":[[0.5,0],[0,0]],"label":"x"})");
  ASSERT_TRUE(bytes);
  std::vector<Value> values;
  columns.values(bytes->data(), bytes->size(), values);
  EXPECT_EQ(1, values[0].number(true));
  EXPECT_TRUE(std::isnan(values[1].number(false)));
  EXPECT_EQ(0.5, values[2].number(false));
  EXPECT_TRUE(std::isnan(values[6].number(false)));
}

TEST(Columns, AreLimitedInNumber) {
  const auto type =
      type_of(R"({"name":"picture","type":"octet","sequence":1000000},{"name":"b","type":"octet"})");
  const Columns columns{type};
  EXPECT_EQ(Columns::kMost, columns.all().size());
  EXPECT_TRUE(columns.cut());
  EXPECT_EQ("7", texts(columns, type, R"({"picture":[1,7],"b":9})")[1]);
}

TEST(Csv, QuotesFieldsWithCommasQuotesOrLineBreaks) {
  EXPECT_EQ("a", csv_field("a"));
  EXPECT_EQ("\"a,b\"", csv_field("a,b"));
  EXPECT_EQ("\"say \"\"no\"\"\"", csv_field("say \"no\""));
  EXPECT_EQ("\"two\nlines\"", csv_field("two\nlines"));
  EXPECT_EQ("a,,\"b,c\"\r\n", csv_line({"a", "", "b,c"}));
}

TEST(Patterns, AnAsteriskMatchesAnyText) {
  EXPECT_TRUE(client::matches("line.*", "line.conveyor.state"));
  EXPECT_TRUE(client::matches("*.state", "line.conveyor.state"));
  EXPECT_TRUE(client::matches("l*e.*.s*", "line.conveyor.state"));
  EXPECT_TRUE(client::matches("*", "a.b.c"));
  EXPECT_FALSE(client::matches("line.*", "robot.line.state"));
  EXPECT_FALSE(client::matches("*.stat", "line.conveyor.state"));
  EXPECT_FALSE(client::matches("line.conveyor.state", "line.conveyor.states"));
  EXPECT_TRUE(client::may_match("line.*", "line"));
  EXPECT_TRUE(client::may_match("l*.x", "line"));
  EXPECT_FALSE(client::may_match("line.*", "lines"));
  EXPECT_FALSE(client::may_match("r*", "line"));
}

TEST(Patterns, APortNameConsistsOfDeviceModuleAndPort) {
  ASSERT_TRUE(client::parse_port("a.b.c"));
  EXPECT_EQ("b", client::parse_port("a.b.c")->module);
  for (const char* wrong : {"", "a", "a.b", "a.b.", ".b.c", "a..c", "a.b.c.d"})
    EXPECT_FALSE(client::parse_port(wrong)) << wrong;
  EXPECT_FALSE(client::check_ports({}));
  EXPECT_FALSE(client::check_ports({"a.b.c", "x"}));
  EXPECT_TRUE(client::check_ports({"a.b.c", "x*"}));
}

}  // namespace
}  // namespace takt::recording::columns_test
