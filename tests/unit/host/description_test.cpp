#include <takt/host/description.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <utility>

namespace takt::host::description_test {
namespace {

TEST(Description, ReadsThePropertiesThatAProgramReports) {
  const auto read = parse_properties(
      R"([{"name":"speed","type":"double","default":"0.5","range":"0 to 2","min":"0","max":"2","unit":"m/s","text":"Of \"it\"."}])");
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read.value(), (std::vector<PropertyDescription>{
                              {"speed", "double", "0.5", "0 to 2", "0", "2", "m/s", "Of \"it\"."}}));
  EXPECT_TRUE(parse_properties("[]").value().empty());
}

TEST(Description, RejectsMalformedPropertyLists) {
  for (const char* text : {"", "{}", "[1]", R"([{"type":"double"}])", "[", "[{\"name\":3}]"})
    EXPECT_FALSE(parse_properties(text)) << text;
}

TEST(Description, WritesMissingBoundsAsJsonNull) {
  const auto object =
      nlohmann::json::parse(to_json({.name = "n",
                                     .text = "t",
                                     .interface = "c",
                                     .operation = {},
                                     .hooks = {"run"},
                                     .properties = {{"a", "integer", "3", "at least 1", "1", "", "", ""}},
                                     .ports = {},
                                     .saved = SavedDescription{.version = 2, .bytes = 24}}));
  EXPECT_EQ(object["saved"]["version"], 2);
  EXPECT_EQ(object["saved"]["bytes"], 24);
  EXPECT_EQ(object["properties"][0]["min"], 1);
  EXPECT_TRUE(object["properties"][0]["max"].is_null());
  EXPECT_EQ(object["properties"][0]["range"], "at least 1");
  EXPECT_TRUE(object["ports"].empty());
  EXPECT_EQ(object["hooks"], nlohmann::json::array({"run"}));
  for (const auto& [member, value] :
       {std::pair{"name", "n"}, {"text", "t"}, {"interface", "c"}, {"operation", ""}})
    EXPECT_EQ(object[member], value);
}

TEST(Description, AcceptsAnyPropertyIfACComponentDeclaresNone) {
  EXPECT_FALSE((Description{.interface = "c++"}.takes_any_property()));
  EXPECT_TRUE((Description{.interface = "c"}.takes_any_property()));
  EXPECT_FALSE((Description{.interface = "process", .properties = {{.name = "a"}}}.takes_any_property()));
}

}  // namespace
}  // namespace takt::host::description_test
