#include <takt/client/answer_data.hpp>

#include <gmock/gmock.h>

#include <takt/model/json.hpp>

namespace takt::client::answer_data_test {
namespace {

using json = nlohmann::ordered_json;
using testing::ElementsAre;

const std::string kUnreadable =
    "device robot: error: its answer cannot be read; check that it runs the same version of Takt as this "
    "program";

TEST(ReadAnswer, NamesTheDeviceIfAMemberIsMissingOrHasAnotherType) {
  const auto read = [](const json& answer) { static_cast<void>(answer.at("a").get<std::string>()); };
  EXPECT_TRUE(read_answer("robot", R"({"a": "x"})", read).ok());
  for (const char* data : {"", "no JSON", "5", "null", "[]", "{}", R"({"a": 5})", R"({"a": null})"})
    EXPECT_EQ(to_text(read_answer("robot", data, read).problems()), kUnreadable) << data;
}

TEST(DescribedModules, HaveAListOfPortsAndProperties) {
  const auto modules = described_modules(
      "robot",
      R"({"modules": [{"name": "arm", "ports": {"ports": [{"name": "in"}]}, "properties": [{"name": "gain"}]},
                      {"name": "exe", "ports": null}]})");
  ASSERT_TRUE(modules.ok()) << to_text(modules.problems());
  EXPECT_EQ((*modules)[0]["ports"], json::parse(R"([{"name": "in"}])"));
  EXPECT_EQ((*modules)[0]["properties"], json::parse(R"([{"name": "gain"}])"));
  EXPECT_EQ((*modules)[1]["ports"], json::array());
  EXPECT_EQ((*modules)[1]["properties"], json::array());
}

TEST(DescribedModules, RejectAnyOtherAnswer) {
  for (const char* data :
       {"", "5", "{}", R"({"modules": 5})", R"({"modules": [5]})", R"({"modules": [{"name": 5}]})",
        R"({"modules": [{"name": "m", "ports": 5}]})", R"({"modules": [{"name": "m", "ports": {}}]})",
        R"({"modules": [{"name": "m", "ports": {"ports": [5]}}]})",
        R"({"modules": [{"name": "m", "properties": {}}]})",
        R"({"modules": [{"name": "m", "properties": [{"name": null}]}]})"}) {
    const auto modules = described_modules("robot", data);
    ASSERT_FALSE(modules.ok()) << data;
    EXPECT_EQ(to_text(modules.problems()), kUnreadable) << data;
  }
}

}  // namespace
}  // namespace takt::client::answer_data_test
