#include "reports/violations_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::tool::violations_report_test {
namespace {

using json = nlohmann::ordered_json;

json device(json violations) { return {{"name", "d"}, {"realtime_violations", std::move(violations)}}; }

TEST(ViolationsReport, IsEmptyIfNothingWasChecked) {
  EXPECT_EQ(violations_text({{"devices", json::array({{{"name", "d"}}})}}), "");
}

TEST(ViolationsReport, SaysIfNoViolationWasFound) {
  EXPECT_EQ(violations_text({{"devices", json::array({device(json::array())})}}),
            "\nno real-time violations\n");
}

TEST(ViolationsReport, ListsViolationsByModuleAndExecutor) {
  const json list = json::array({{{"module", "m"},
                                  {"hook", "run()"},
                                  {"kind", "allocation"},
                                  {"what", "malloc"},
                                  {"count", 12},
                                  {"backtrace", {"f at m.cpp:3 in m.so", "run at m.cpp:9 in m.so"}}},
                                 {{"module", ""},
                                  {"executor", "main"},
                                  {"hook", ""},
                                  {"kind", "page fault"},
                                  {"what", ""},
                                  {"count", 1},
                                  {"backtrace", json::array()}}});
  EXPECT_EQ(violations_text({{"devices", json::array({device(list)})}}),
            "\nreal-time violations:\n"
            "  d.m run(): allocation malloc, 12 times\n"
            "      f at m.cpp:3 in m.so\n"
            "      run at m.cpp:9 in m.so\n"
            "  d.executor main: page fault, once\n");
}

}  // namespace
}  // namespace takt::tool::violations_report_test
