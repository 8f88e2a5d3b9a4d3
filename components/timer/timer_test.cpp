#include "iec_timer.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace timer {
namespace {

using common::flag;
using std::chrono::milliseconds;

/// Checks a timing diagram of IEC 61131-3: IN, Q and ET (hexadecimal) at each step of one time unit.
void expect_diagram(Kind kind, std::int64_t preset, const std::string& in, const std::string& q,
                    const std::string& et) {
  IecTimer timer;
  std::string was_q;
  std::string was_et;
  for (const char c : in) {
    was_q += timer.step(kind, c == '1', 1, preset) ? '1' : '0';
    was_et += "0123456789abcdef"[timer.elapsed_ns()];
  }
  EXPECT_EQ(was_q, q);
  EXPECT_EQ(was_et, et);
}

TEST(IecTimer, OnDelayFollowsItsDiagram) {
  expect_diagram(Kind::on_delay, 4,         //
                 "0111111110011001111110",  //
                 "0000011110000000000110",  //
                 "0012344440001000123440");
}

TEST(IecTimer, OffDelayFollowsItsDiagram) {
  expect_diagram(Kind::off_delay, 4,        //
                 "0001100000001001000000",  //
                 "0001111110001111111100",  //
                 "0000001234440010012344");
}

TEST(IecTimer, PulseFollowsItsDiagram) {
  expect_diagram(Kind::pulse, 4,                //
                 "01000000111111101101100000",  //
                 "01111000111100001111000000",  //
                 "00123000012344400123400000");
}

TEST(IecTimer, HasNoDelayAndNoPulseIfItsTimeIsZero) {
  for (const Kind kind : {Kind::on_delay, Kind::off_delay})
    expect_diagram(kind, 0, "0110100", "0110100", "0000000");
  expect_diagram(Kind::pulse, 0, "0110100", "0000000", "0000000");
}

/// A slow reference that derives Q from all earlier values.
bool naive(Kind kind, const std::vector<bool>& in, const std::vector<std::int64_t>& at, std::int64_t preset) {
  const std::size_t now = in.size() - 1;
  if (kind == Kind::pulse) {
    // Pulses do not overlap. A rising edge starts a pulse only if no pulse is active.
    std::int64_t end = -1;
    bool covered = false;
    for (std::size_t i = 0; i <= now; ++i) {
      if (covered && at[i] >= end) {
        covered = false;
        continue;  // an edge in the step that ends a pulse still belongs to that pulse
      }
      if (!covered && in[i] && (i == 0 || !in[i - 1])) {
        covered = preset > 0;
        end = at[i] + preset;
      }
    }
    return covered;
  }
  std::size_t since = now;  // the step at which the input took its present value
  while (since > 0 && in[since - 1] == in[now]) --since;
  const bool over = at[now] - at[since] >= preset;
  if (kind == Kind::on_delay) return in[now] && over;
  return in[now] || (since > 0 && !over);
}

TEST(IecTimer, MatchesASlowReferenceForRandomInputsAndGaps) {
  std::mt19937 random(14);
  for (const Kind kind : {Kind::on_delay, Kind::off_delay, Kind::pulse}) {
    for (int n = 0; n < 60; ++n) {
      const std::int64_t preset = static_cast<std::int64_t>(random() % 12);
      IecTimer timer;
      std::vector<bool> in;
      std::vector<std::int64_t> at;
      std::int64_t now = 0;
      bool value = false;
      for (int i = 0; i < 400; ++i) {
        if (random() % 5 == 0) value = !value;
        const auto passed = static_cast<std::int64_t>(random() % 4 == 0 ? random() % 5 + 1 : 1);
        now += passed;
        in.push_back(value);
        at.push_back(now);
        ASSERT_EQ(timer.step(kind, value, passed, preset), naive(kind, in, at, preset))
            << static_cast<int>(kind) << " " << preset << " " << i;
        ASSERT_GE(timer.elapsed_ns(), 0);
        ASSERT_LE(timer.elapsed_ns(), preset);
      }
    }
  }
}

TEST(Timer, CountsFromTheReleaseThatDetectsTheEdge) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  auto& in = module.in<basic::Flag>("in");
  auto& q = module.out<basic::Flag>("q");
  auto& et = module.out<basic::Number>("et");
  ASSERT_TRUE(module.set("time", "0.1"));
  ASSERT_TRUE(module.start());
  module.step(20);
  EXPECT_FALSE(q.value().value());  // without a sample, the input counts as false
  in.write(flag(true));
  module.step(10);
  EXPECT_FALSE(q.value().value());
  EXPECT_NEAR(et.value().value(), 0.09, 1e-12);
  module.step();
  EXPECT_TRUE(q.value().value());
}

TEST(Timer, CountsTheTimeOfMissedReleases) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  auto& in = module.in<basic::Flag>("in");
  auto& q = module.out<basic::Flag>("q");
  auto& et = module.out<basic::Number>("et");
  ASSERT_TRUE(module.start());  // the default time is 1 s
  in.write(flag(true));
  module.step();
  module.miss(98);
  module.step();
  EXPECT_FALSE(q.value().value());
  EXPECT_NEAR(et.value().value(), 0.99, 1e-12);
  module.step();
  EXPECT_TRUE(q.value().value());
}

TEST(Timer, AppliesANewTimeToARunningTimer) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  auto& in = module.in<basic::Flag>("in");
  auto& q = module.out<basic::Flag>("q");
  ASSERT_TRUE(module.set("kind", "TOF"));
  ASSERT_TRUE(module.start());
  in.write(flag(true));
  module.step();
  in.write(flag(false));
  module.step(50);
  EXPECT_TRUE(q.value().value());
  ASSERT_TRUE(module.set("time", "0.2"));
  module.step();
  EXPECT_FALSE(q.value().value());
}

TEST(Timer, RestartsWhenItsKindChanges) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  auto& in = module.in<basic::Flag>("in");
  auto& q = module.out<basic::Flag>("q");
  auto& et = module.out<basic::Number>("et");
  ASSERT_TRUE(module.set("kind", "TP"));
  ASSERT_TRUE(module.start());  // the default time is 1 s
  in.write(flag(true));
  module.step(60);
  EXPECT_TRUE(q.value().value());
  ASSERT_TRUE(module.set("kind", "TON"));
  module.step(61);
  EXPECT_FALSE(q.value().value()) << "the time before the change must not count";
  EXPECT_NEAR(et.value().value(), 0.6, 1e-9);
  module.step(40);
  EXPECT_TRUE(q.value().value());
}

TEST(Timer, RejectsAnUnknownKind) {
  takt::testing::Module module;
  const auto rejected = module.set("kind", "TONR");
  ASSERT_FALSE(rejected.ok());
  EXPECT_EQ(rejected.text(), "property 'kind' cannot be 'TONR'; it takes text, TON, TOF or TP");
}

}  // namespace
}  // namespace timer
