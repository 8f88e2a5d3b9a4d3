#include <takt/client/status.hpp>

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace takt::client::status_test {
namespace {

using json = nlohmann::ordered_json;
using testing::ElementsAre;
using testing::IsEmpty;

json device(const std::string& name, const json& deployment, const json& update = nullptr,
            bool alive = true) {
  return {{"name", name}, {"alive", alive}, {"deployment", deployment}, {"update", update}};
}

TEST(Differences, AreNotReportedIfAllLiveDevicesHaveTheSameDeployment) {
  const json devices{device("line", "a1", "u1"), device("robot", "a1", "u1"),
                     device("saw", "a1", nullptr, false), device("free", nullptr)};
  EXPECT_THAT(differences(devices, {{"cell", {"line", "robot", "saw"}}}), IsEmpty());
}

TEST(Differences, NameTheDevicesOfEachDeploymentAndUpdate) {
  const json devices{device("line", "a1"), device("press", nullptr), device("robot", "a1", "u1"),
                     device("saw", "a1")};
  EXPECT_THAT(
      differences(devices, {{"cell", {"line", "press", "robot", "saw"}}}),
      ElementsAre("the devices of cell cell differ: line, saw: deployment a1; robot: deployment a1 with "
                  "update u1; press: no deployment; to make them agree, run takt deploy --update with the "
                  "descriptor of the cell, or takt undeploy cell"));
}

}  // namespace
}  // namespace takt::client::status_test
