#include "reports/log_report.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <ctime>

namespace takt::tool::log_report_test {
namespace {

using model::Fault;
using model::FaultKind;
using testing::HasSubstr;

constexpr std::int64_t kNow = 1'772'368'205'250'000'000;  // 2026-03-01 12:30:05.250 UTC

class LogText : public testing::Test {
 protected:
  void SetUp() override {
    ::setenv("TZ", "UTC", 1);
    ::tzset();
  }
  static Fault overrun() {
    return {.sequence = 7,
            .time_ns = kNow,
            .cell = "cell",
            .device = "robot",
            .module = "servo",
            .kind = FaultKind::overrun,
            .cause = "it was not done",
            .count = 3,
            .cycle = 1200};
  }
  static std::string text(const std::vector<Fault>& events, bool colour = false) {
    std::string day;
    return log_text(events, day, {.colour = colour, .width = 80});
  }
};

TEST_F(LogText, PrintsOneLinePerEvent) {
  Fault brief = overrun();
  brief.count = 1;
  brief.cycle = 0;
  EXPECT_EQ(text({brief}), "2026-03-01\n12:30:05.250 ! robot.servo      overrun         it was not done\n");
}

TEST_F(LogText, PrintsALongCauseBelowTheEvent) {
  EXPECT_EQ(text({overrun()}),
            "2026-03-01\n"
            "12:30:05.250 ! robot.servo      overrun\n"
            "               it was not done (3 times) [after 1200 cycles]\n");
  Fault crash = overrun();
  crash.kind = FaultKind::error;
  crash.error = "crash";
  crash.cause.assign(300, 'x');
  crash.cause.append(" and on one line\nonly");
  crash.attachment = "/var/core.1";
  EXPECT_THAT(text({crash}), HasSubstr("\n12:30:05.250 X robot.servo      error\n               crash:\n"));
  EXPECT_THAT(text({crash}),
              HasSubstr("one line\\nonly (3 times) [after 1200 cycles]; see\n               /var/core.1\n"));
}

TEST_F(LogText, DistinguishesTheReleaseOfALogLineFromTheCyclesOfAModule) {
  Fault event = overrun();
  event.count = 1;
  event.cycle = 1;
  EXPECT_THAT(text({event}), HasSubstr("it was not done [after 1 cycle]\n"));
  for (const FaultKind kind :
       {FaultKind::log_error, FaultKind::log_warning, FaultKind::log_info, FaultKind::log_debug}) {
    event.kind = kind;
    EXPECT_THAT(text({event}), HasSubstr("it was not done [release 1]\n"));
  }
}

TEST_F(LogText, PrintsEachDayOnlyOnce) {
  std::string day;
  const Style style{.colour = false, .width = 80};
  EXPECT_THAT(log_text({overrun(), overrun()}, day, style), testing::StartsWith("2026-03-01\n12"));
  EXPECT_THAT(log_text({overrun()}, day, style), testing::StartsWith("12:30"));
  Fault next = overrun();
  next.time_ns += 86400 * std::int64_t{1'000'000'000};
  EXPECT_THAT(log_text({next}, day, style), testing::StartsWith("2026-03-02\n12"));
}

TEST_F(LogText, MarksTheSeverityEvenWithoutColour) {
  std::string plain = text({overrun()}, true);
  EXPECT_THAT(plain, HasSubstr("\033[33moverrun\033[0m"));
  for (const char* escape : {"\033[33m", "\033[0m"})
    plain.erase(plain.find(escape), std::string{escape}.size());
  EXPECT_EQ(plain, text({overrun()}));
}

TEST_F(LogText, PrintsOneJsonObjectPerLine) {
  EXPECT_EQ(
      log_json({overrun()}),
      R"({"sequence":7,"time_ns":1772368205250000000,"cell":"cell","device":"robot","module":"servo",)"
      R"("kind":"overrun","severity":"warning","error":null,"cause":"it was not done","attachment":null,)"
      R"("count":3,"cycle":1200})"
      "\n");
}

TEST_F(LogText, BeginsAtAGivenAgeOrTime) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  EXPECT_EQ(*since_from("90s", kNow), kNow - 90 * kSecond);
  EXPECT_EQ(*since_from("10m", kNow), kNow - 600 * kSecond);
  EXPECT_EQ(*since_from("2h", kNow), kNow - 7200 * kSecond);
  EXPECT_EQ(*since_from("7d", kNow), kNow - 7 * 86400 * kSecond);
  const std::int64_t midnight = 1'772'323'200 * kSecond;
  EXPECT_EQ(*since_from("2026-03-01", kNow), midnight);
  EXPECT_EQ(*since_from("12:30", kNow), midnight + 45000 * kSecond);
  for (const char* when : {"2026-03-01T12:30:05", "2026-03-01 12:30:05", "12:30:05"})
    EXPECT_EQ(*since_from(when, kNow), midnight + 45005 * kSecond) << when;
  for (const char* wrong :
       {"", "soon", "10", "m", "-10m", "10x", "10m ", "25:00", "2026-13-01", "99999999999d"}) {
    const auto since = since_from(wrong, kNow);
    ASSERT_FALSE(since.ok()) << wrong;
    EXPECT_THAT(in_words(since.problems()), HasSubstr("10m")) << wrong;
  }
}

}  // namespace
}  // namespace takt::tool::log_report_test
