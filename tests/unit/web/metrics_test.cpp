#include "web/metrics.hpp"

#include <fstream>
#include <iterator>
#include <regex>

#include <gmock/gmock.h>

#include "seen.hpp"

#include <folders.hpp>

namespace takt::tool::web::metrics_test {
namespace {

using namespace seen;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string text() {
  const model::Cell press = cell();
  return metrics_text(cell_that_runs(), &press, {.faults = {{"robot", {1, 0, 5}}}, .viewers = 2});
}

TEST(Metrics, HaveOneTimeSeriesPerPossibleState) {
  EXPECT_THAT(
      text(),
      AllOf(
          HasSubstr("# TYPE takt_module_state gauge\n"),
          HasSubstr(
              "takt_module_state{cell=\"press\",device=\"robot\",module=\"servo\",state=\"EXECUTING\"} 1\n"),
          HasSubstr(
              "takt_module_state{cell=\"press\",device=\"robot\",module=\"servo\",state=\"RECOVER\"} 0\n"),
          HasSubstr(
              "takt_module_state{cell=\"press\",device=\"robot\",module=\"slow\",state=\"RECOVER\"} 1\n")));
}

TEST(Metrics, MeasureTimesInSeconds) {
  EXPECT_THAT(
      text(),
      AllOf(
          HasSubstr("takt_module_jitter_seconds{cell=\"press\",device=\"robot\",module=\"servo\",quantile="
                    "\"0.99\"} 4e-05\n"),
          HasSubstr("takt_module_run_max_seconds{cell=\"press\",device=\"robot\",module=\"servo\"} 0.0001\n"),
          HasSubstr("# TYPE takt_module_overruns_total counter\n"),
          HasSubstr("takt_module_overruns_total{cell=\"press\",device=\"robot\",module=\"servo\"} 3\n"),
          HasSubstr(
              "takt_executor_margin_seconds{cell=\"press\",device=\"robot\",executor=\"main\"} 5e-05\n"),
          HasSubstr("takt_device_host_restarts_total{cell=\"press\",device=\"robot\"} 2\n"),
          HasSubstr("takt_device_forced_inputs{cell=\"press\",device=\"robot\"} 0\n"),
          HasSubstr("takt_device_unacknowledged_alarms{cell=\"press\",device=\"robot\"} 3\n"),
          HasSubstr("takt_faults_total{device=\"robot\",severity=\"error\"} 5\n"),
          HasSubstr("takt_web_viewers 2\n")));
}

TEST(Metrics, ContainTheOffsetOfAClockIfItIsKnown) {
  wire::ObservedDevice robot = device("robot");
  EXPECT_THAT(metrics_text({robot}, nullptr, {}), Not(HasSubstr("clock_offset")));
  robot.status.clock_offset_ns(-2'500'000);
  robot.status.clock_error_ns(400'000);
  robot.alive = true;
  EXPECT_THAT(
      metrics_text({robot}, nullptr, {}),
      AllOf(HasSubstr("# TYPE takt_device_clock_offset_seconds gauge\n"),
            HasSubstr("takt_device_clock_offset_seconds{cell=\"press\",device=\"robot\"} -0.0025\n"),
            HasSubstr("takt_device_clock_offset_error_seconds{cell=\"press\",device=\"robot\"} 0.0004\n")));
  robot.alive = false;
  EXPECT_THAT(metrics_text({robot}, nullptr, {}), Not(HasSubstr("clock_offset")));
}

// A monitoring system would take the last values of a lost device for current values.
TEST(Metrics, OmitTheMeasurementsOfALostDevice) {
  EXPECT_THAT(text(), AllOf(HasSubstr("takt_device_up{cell=\"press\",device=\"line\"} 0\n"),
                            Not(HasSubstr("module=\"vision\"")),
                            Not(HasSubstr("takt_device_state{cell=\"press\",device=\"line\""))));
}

TEST(Metrics, IncludeADeviceLostBeforeTheGatewayStarted) {
  const model::Cell press = cell();
  auto devices = cell_that_runs();
  std::erase_if(devices, [](const wire::ObservedDevice& device) { return device.name() == "line"; });
  EXPECT_THAT(metrics_text(devices, &press, {}),
              HasSubstr("takt_device_up{cell=\"press\",device=\"line\"} 0\n"));
  EXPECT_THAT(metrics_text(devices, nullptr, {}), Not(HasSubstr("device=\"line\"")));
}

// Prometheus rejects two samples with the same name and labels.
TEST(Metrics, ShowOnlyTheLiveNodeOfTwoWithTheSameName) {
  const model::Cell press = cell();
  auto devices = cell_that_runs();
  auto dead = devices.front();
  dead.alive = false;
  devices.insert(devices.begin(), dead);
  devices.push_back(devices.front());
  EXPECT_EQ(metrics_text(cell_that_runs(), &press, {}), metrics_text(devices, &press, {}));
}

TEST(Metrics, ShowTheHealthOfEachConnection) {
  EXPECT_THAT(
      text(),
      AllOf(HasSubstr(
                "takt_connection_stale{cell=\"press\",from=\"robot.servo.angle\",to=\"line.vision.angle\","
                "topic=\"takt/press/robot/servo/angle\"} 1\n"),
            HasSubstr(
                "takt_connection_age_seconds{cell=\"press\",from=\"robot.servo.angle\",to=\"\",topic=\"plant/"
                "angle\"} 0.0005\n")));
  EXPECT_THAT(metrics_text(cell_that_runs(), nullptr, {}), Not(HasSubstr("takt_connection")));
}

TEST(Metrics, OmitMetricFamiliesWithoutSamples) {
  EXPECT_EQ(
      metrics_text({}, nullptr, {}),
      "# HELP takt_web_viewers Open event streams.\n# TYPE takt_web_viewers gauge\ntakt_web_viewers 0\n");
}

TEST(Metrics, ContainEveryMetricThatTheDashboardUses) {
  std::ifstream file{source_path("config/grafana-takt.json")};
  const std::string dashboard{std::istreambuf_iterator<char>{file}, {}};
  const std::regex name{"takt_[a-z_]+"};
  std::size_t found = 0;
  for (std::sregex_iterator at{dashboard.begin(), dashboard.end(), name}; at != std::sregex_iterator{};
       ++at, ++found)
    EXPECT_THAT(text(), HasSubstr("# TYPE " + at->str() + " "));
  EXPECT_GT(found, 10U);
}

TEST(Metrics, EscapeSpecialCharactersInLabels) {
  auto devices = cell_that_runs();
  wire::set(devices[1].status.cell(), "a\"b\\c\nd");
  EXPECT_THAT(metrics_text(devices, nullptr, {}),
              HasSubstr(R"(takt_device_up{cell="a\"b\\c\nd",device="robot"} 1)"));
}

}  // namespace
}  // namespace takt::tool::web::metrics_test
