#include "reports/properties_report.hpp"

#include <gmock/gmock.h>

namespace takt::tool::properties_report_test {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;
using testing::Not;

TEST(PropertiesReport, ShowsValueUnitRangeAndTypeOfEachProperty) {
  const Json properties = Json::array(
      {{{"name", "speed"}, {"type", "double"}, {"range", "0 to 2"}, {"unit", "m/s"}, {"value", "0.5"}},
       {{"name", "label"}, {"type", "string"}, {"range", ""}, {"unit", ""}, {"value", ""}},
       {{"name", "gain"}, {"type", "double"}, {"value", nullptr}}});
  const std::string text = properties_text(properties, {});
  EXPECT_THAT(text, testing::ContainsRegex("speed +0.5 +m/s +0 to 2 +double\n"));
  EXPECT_THAT(text, testing::ContainsRegex("label +'' +string\n"));
  EXPECT_THAT(text, testing::ContainsRegex("gain +not known +double\n"));
}

TEST(PropertiesReport, SaysThatAComponentDeclaresNoProperties) {
  EXPECT_EQ("the component declares no properties\n", properties_text(Json::array(), {}));
}

TEST(PropertiesReport, PrintsNoControlCharactersOfAValue) {
  const Json properties = Json::array({{{"name", "label"}, {"type", "string"}, {"value", "a\n\033[31mb"}}});
  EXPECT_THAT(properties_text(properties, {}), Not(HasSubstr("\033")));
}

}  // namespace
}  // namespace takt::tool::properties_report_test
