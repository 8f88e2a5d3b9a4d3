#include <takt/model/profile_json.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::model::profile_json_test {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;

Profile profile() {
  return {
      .cell = "cell",
      .modules = {{"robot.servo", {.runs = 10, .min = 1us, .p50 = 2us, .p99 = 3us, .p999 = 4us, .max = 5us}},
                  {"robot.never", {}}}};
}

Problems problems_of(const std::string& text) {
  const auto parsed = parse_profile(text, "p.json");
  return parsed ? Problems{} : parsed.problems();
}

/// Returns the JSON of a profile with one module, d.m, which has these entries.
std::string of_module(const std::string& entries) {
  return "{\"cell\": \"c\", \"modules\": {\n\"d.m\": {" + entries + "}}}";
}

auto problem(const std::string& where, const std::string& what, const std::string& fix) {
  return AllOf(Field(&Problem::where, where), Field(&Problem::what, HasSubstr(what)),
               Field(&Problem::fix, HasSubstr(fix)));
}

TEST(ProfileJson, SurvivesARoundTrip) {
  const auto read = parse_profile(profile_json(profile(), {{"kernel", "6.1"}}), "p.json");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->cell, "cell");
  ASSERT_EQ(read->modules.size(), 2U);
  const RunTimes& servo = read->modules.at("robot.servo");
  EXPECT_EQ(servo.runs, 10U);
  EXPECT_THAT((std::vector{servo.min, servo.p50, servo.p99, servo.p999, servo.max}),
              ElementsAre(1us, 2us, 3us, 4us, 5us));
  EXPECT_EQ(read->modules.at("robot.never").runs, 0U);
}

TEST(ProfileJson, DescribesTheMachineOnWhichItWasMeasured) {
  EXPECT_THAT(profile_json(profile(), {{"kernel", "6.1"}}), HasSubstr("\"kernel\": \"6.1\""));
}

TEST(ProfileJson, ReportsTheLineAtWhichItsTextIsNotJson) {
  EXPECT_THAT(problems_of("{\"cell\": \"c\",\n\n oops"),
              ElementsAre(problem("p.json:3", "not JSON", "takt run --profile")));
  EXPECT_THAT(problems_of(""), ElementsAre(problem("p.json:1", "not JSON", "")));
  EXPECT_THAT(problems_of("[]"), ElementsAre(problem("p.json:1", "not a profile", "")));
}

TEST(ProfileJson, ReportsAMissingCellNameAndMissingModules) {
  EXPECT_THAT(problems_of("{}"),
              ElementsAre(problem("p.json:1", "does not name its cell", "\"cell\": \"NAME\""),
                          problem("p.json:1", "the profile has no \"modules\" object", "")));
}

TEST(ProfileJson, SuggestsASimilarKeyForAnUnknownKey) {
  EXPECT_THAT(problems_of(R"({"cell": "c", "module": {}, "modules": {}})"),
              ElementsAre(problem("p.json:1", "'module'", "did you mean modules?")));
}

TEST(ProfileJson, ReportsEachMissingRunTime) {
  EXPECT_THAT(problems_of(of_module(R"("runs": 1, "min_ns": 1, "p50_ns": 1, "p99_ns": 1)")),
              ElementsAre(problem("p.json:2", "'d.m' has no \"p999_ns\"", ""),
                          problem("p.json:2", "'d.m' has no \"max_ns\"", "")));
}

TEST(ProfileJson, RejectsRunTimesThatAreNotWholeNumbers) {
  for (const char* bad : {"-1", "1.5", "\"5\"", "null", "9223372036854775808"}) {
    const std::string entries =
        R"("runs": 1, "min_ns": 0, "p50_ns": 0, "p99_ns": 0, "p999_ns": 0, "max_ns": )" + std::string{bad};
    EXPECT_THAT(problems_of(of_module(entries)),
                ElementsAre(problem("p.json:2", "\"max_ns\" of 'd.m' is", "whole number from 0")))
        << bad;
  }
}

TEST(ProfileJson, RejectsPercentilesThatDecrease) {
  EXPECT_THAT(
      problems_of(
          of_module(R"("runs": 1, "min_ns": 2, "p50_ns": 2, "p99_ns": 9, "p999_ns": 3, "max_ns": 4)")),
      ElementsAre(problem("p.json:2", "\"p99_ns\" of 'd.m' is larger than \"p999_ns\"", "do not decrease")));
}

TEST(ProfileJson, RejectsModuleNamesNotOfTheFormDeviceDotModule) {
  for (const char* name : {"m", ".m", "d.", "a.b.c"}) {
    const std::string text = R"({"cell": "c", "modules": {")" + std::string{name} + R"(": 1}})";
    EXPECT_THAT(problems_of(text),
                ElementsAre(problem("p.json:1", "is not the name of a module", "device.module"),
                            problem("p.json:1", "no run times", "an object")));
  }
}

}  // namespace
}  // namespace takt::model::profile_json_test
