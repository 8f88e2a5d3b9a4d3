#include "reports/doctor_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace takt::tool::doctor_report_test {
namespace {

using json = nlohmann::ordered_json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string kCommand =
    "for cpu in /sys/devices/system/cpu/cpu[0-9]*; do echo performance > "
    "$cpu/cpufreq/scaling_governor; done # and a word more, so that it is long";

json finding(const char* check, const char* severity, const std::string& cure = {},
             const char* mend_on = "") {
  return {{"check", check},
          {"severity", severity},
          {"found", std::string{"found of "} + check},
          {"why", std::string{"why of "} + check},
          {"cure", cure},
          {"mend_on", mend_on}};
}

json report() {
  return {{"machine", "cell7"},
          {"root", true},
          {"spoils", 1},
          {"notes", 2},
          {"findings", json::array({finding("clock", "good"), finding("frequency", "note", kCommand),
                                    finding("stolen", "note", "pin it", "the host"),
                                    finding("priority", "spoils", "be root")})}};
}

TEST(DoctorReport, ListsProblemsFirstAndGoodChecksLast) {
  const std::string text = doctor_text(report(), {});
  EXPECT_LT(text.find("priority"), text.find("frequency"));
  EXPECT_LT(text.find("stolen"), text.find("clock"));
  EXPECT_THAT(text, HasSubstr("machine cell7: 1 finding spoils real-time behaviour, 2 notes\n"));
}

TEST(DoctorReport, NeverWrapsACommandLine) {
  EXPECT_THAT(doctor_text(report(), {.width = 80}), HasSubstr("cure: " + kCommand + "\n"));
}

TEST(DoctorReport, WrapsOtherTextToTheWidthOfTheTerminal) {
  std::istringstream lines{doctor_text(report(), {.width = 80})};
  for (std::string line; std::getline(lines, line);) {
    const bool is_cure = line.find("cure: ") != std::string::npos;
    EXPECT_TRUE(is_cure || line.size() <= 80U) << line;
  }
}

TEST(DoctorReport, NamesTheMachineOnWhichAFixMustBeApplied) {
  EXPECT_THAT(doctor_text(report(), {}),
              HasSubstr("cure: not possible on this machine; on the host: pin it\n"));
}

TEST(DoctorReport, UsesColourOnlyOnRequest) {
  EXPECT_THAT(doctor_text(report(), {}), Not(HasSubstr("\x1b")));
  EXPECT_THAT(doctor_text(report(), {.colour = true}), HasSubstr("\x1b["));
}

TEST(DoctorReport, SaysIfItWasNotRunAsRoot) {
  json of = report();
  EXPECT_THAT(doctor_text(of, {}), Not(HasSubstr("takt doctor did not run as root")));
  of["root"] = false;
  of["spoils"] = 0;
  of["notes"] = 0;
  EXPECT_THAT(doctor_text(of, {}), AllOf(HasSubstr("takt doctor did not run as root"),
                                         HasSubstr("nothing found that spoils real-time behaviour\n")));
}

}  // namespace
}  // namespace takt::tool::doctor_report_test
