// Tests the check of reports. takt checks the report of a node only when it receives the report, so the check
// must reject everything that the output functions cannot show.
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <takt/client/answer_data.hpp>

#include "reports/graph_report.hpp"
#include "reports/profile_report.hpp"
#include "reports/run_report.hpp"
#include "reports/violations_report.hpp"

namespace takt::tool::checked_report_test {
namespace {

using json = nlohmann::ordered_json;

/// Returns the status of a running device with all members that takt shows.
json running() {
  const auto measured =
      R"({"mean": -1.5, "variance": 0, "min": 0, "p50": 0.25, "p99": 12, "p999": 20, "max": 1450})";
  return json::parse(R"({"cell": "c", "devices": [{
    "name": "robot", "alive": true, "real_time": true, "state": "running", "text": "why", "conflict": "two",
    "cell": "c", "deployment": "d", "update": null,
    "clock": {"reference": "line", "offset_us": 123.4, "bound_us": 400},
    "executors": [{"name": "main", "cycles": 999, "missed": 1, "margin_us": 17.5, "jitter_us": )" +
                     std::string{measured} + R"(}],
    "modules": [{"name": "arm", "type": "thread", "operation": "periodic", "state": "START", "text": "why",
      "given_up": true, "safe_stop": true, "stopped": true,
      "cycles": 1000, "overruns": 2, "errors": 3, "file": "/c/arm.so", "version": "1", "hash": "3fa91c02",
      "jitter_us": )" +
                     measured + R"(, "run_us": )" + measured + R"(,
      "ports": [{"name": "p", "direction": "in", "connections": 2, "matched": 1, "samples": 41, "lost": 5,
                 "dropped": 6, "late": 7, "safe": true, "age_us": 1.5, "incompatible": "reliability",
                 "losing": true, "dropping": true, "rating": "poor", "reason": "degraded"}]}],
    "realtime_violations": [{"module": "arm", "hook": "run", "kind": "lock", "what": "mutex", "count": 2,
                             "backtrace": ["main"]}]}]})");
}

/// Calls `with` for each way of replacing or removing one value within `value`. Restores the value each time.
void damage(json& value, const std::function<void(const std::string&)>& with) {
  const json before = value;
  for (const json& other : {json(nullptr), json(-1), json(1.5), json("x"), json(true), json::array(),
                            json::object(), json::array({5})}) {
    value = other;
    with(other.dump());
  }
  value = before;
  if (!value.is_structured()) return;
  for (const auto& [key, unused] : before.items()) {
    if (value.is_object()) {
      value.erase(key);
      with("without " + key);
      value = before;
    }
    damage(value.is_object() ? value[key] : value[std::stoul(key)], with);
  }
}

TEST(CheckedReport, RejectsEveryReportThatSomeOutputCannotShow) {
  json status = running();
  json& device = status["devices"][0];
  ASSERT_NO_THROW(client::checked_report(device));
  std::size_t accepted = 0;
  std::size_t rejected = 0;
  damage(device, [&](const std::string& what) {
    try {
      client::checked_report(device);
    } catch (const json::exception&) {
      ++rejected;
      return;
    }
    ++accepted;
    EXPECT_NO_THROW(run_text(status)) << what << ": " << device;
    EXPECT_NO_THROW(run_json(status)) << what << ": " << device;
    EXPECT_NO_THROW(components_in(device)) << what << ": " << device;
    EXPECT_NO_THROW(profile_of(status)) << what << ": " << device;
    EXPECT_NO_THROW(violations_text(status)) << what << ": " << device;
    model::Cell c;
    c.name = "c";
    EXPECT_NO_THROW(health_of(c, status)) << what << ": " << device;
  });
  EXPECT_GT(rejected, 500U);
  EXPECT_GT(accepted, 20U);
}

}  // namespace
}  // namespace takt::tool::checked_report_test
