// Tests swaps of a running module in a real host.
#include <gmock/gmock.h>

#include <map>
#include <optional>

#include "real_device.hpp"

namespace takt::node::device_swap_test {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;
using testing::HasSubstr;

class DeviceSwap : public RealDevice {
 protected:
  Outcome swap(std::uint32_t module, const std::string& file,
               const std::map<std::string, std::string>& values = {}) {
    std::optional<Outcome> answer;
    device->swap(module, kComponents + "/" + file, values, [&answer](const Outcome& outcome) {
      EXPECT_FALSE(answer) << "answered twice";
      answer = outcome;
    });
    EXPECT_TRUE(step_until([&] { return answer.has_value(); }));
    return answer.value_or(Outcome{.code = REPLY_LATE, .text = {}});
  }
  void expect_executing(const std::string& name, int errors = 0) {
    EXPECT_EQ(module_of(name)["state"], "EXECUTING");
    EXPECT_EQ(module_of(name)["errors"], errors);
  }
};

TEST_F(DeviceSwap, KeepsServicesAvailable) {
  bring_up(module("answers", "answers.so", kEvery) + module("one", "asks.so", kEvery, file("one")) +
               module("two", "asks.so", kEvery, file("two")),
           R"(<service client="d.one.ask" server="d.answers.handled"/>)"
           R"(<service client="d.two.ask" server="d.answers.polled"/>)");
  wait_for_cycles("one", 50);
  for (int n = 0; n < 30; ++n) {
    const Outcome outcome = swap(0, "answers.so");
    ASSERT_EQ(outcome.code, REPLY_OK) << outcome.text;
    EXPECT_EQ(outcome.state, lifecycle::State::executing);
  }
  run_for(milliseconds{100});
  expect_executing("answers");
  take_down();
  for (const char* client : {"one", "two"}) {
    const json report = seen(client);
    EXPECT_GT(report["replied"], 50) << client;
    EXPECT_EQ(report["timed_out"], 0) << client;
    EXPECT_EQ(report["wrong"], 0) << client;
  }
}

TEST_F(DeviceSwap, KeepsServiceClientsWorking) {
  bring_up(module("answers", "answers.so", kEvery) + module("one", "asks.so", kEvery, file("one")),
           R"(<service client="d.one.ask" server="d.answers.handled"/>)");
  wait_for_cycles("one", 50);
  for (int n = 0; n < 10; ++n) ASSERT_EQ(swap(1, "asks.so").code, REPLY_OK);
  wait_for_cycles("one", module_of("one")["cycles"].get<int>() + 100);
  take_down();
  EXPECT_GT(seen("one")["replied"], 20);
  EXPECT_EQ(seen("one")["wrong"], 0);
}

TEST_F(DeviceSwap, GivesTheNewInstanceOfACModuleItsOwnVariables) {
  bring_up(module("keeps", "keeps_c.so", kEvery) + module("counter", "counter.so", kEvery, file("count")));
  wait_for_cycles("keeps", 20);
  for (int n = 0; n < 5; ++n) {
    const Outcome outcome = swap(0, "keeps_c.so");
    ASSERT_EQ(outcome.code, REPLY_OK) << outcome.text;
  }
  const int before = module_of("counter")["cycles"];
  const Outcome outcome = swap(1, "counter.so");
  ASSERT_EQ(outcome.code, REPLY_OK) << outcome.text;
  // The old instance writes the file `count` when it ends, which is after the new instance has started.
  const auto has_written = [&] {
    const json count = seen("count");
    return count.is_number() && count >= before;
  };
  EXPECT_TRUE(step_until(has_written)) << "the old instance ended cleanly";
  wait_for_cycles("counter", before + 20);
  take_down();
  EXPECT_LT(seen("count"), module_of("counter")["cycles"])
      << "the module saves no state, so the new instance counts from 0";
}

TEST_F(DeviceSwap, RejectsAnImpossibleSwapWithTheReason) {
  bring_up(module("periodic", "fine.so", kEvery) + module("sporadic", "fine_sporadic.so", kSporadic) +
           module("program", "fine.exe", kEvery));
  ASSERT_TRUE(step_until([&] { return module_of("periodic")["state"] == "EXECUTING"; }));
  EXPECT_THAT(swap(1, "fine_sporadic.so").text, HasSubstr("d.sporadic is sporadic; only a periodic module"));
  EXPECT_THAT(swap(2, "fine.so").text, HasSubstr("d.program is a program; only a thread module"));
  const Outcome other = swap(0, "ticks.so");
  EXPECT_EQ(other.code, REPLY_FAILED);
  EXPECT_THAT(other.text, HasSubstr("port 'out' is new"));
  const Outcome bad = swap(0, "undefined_symbol.so");
  EXPECT_EQ(bad.code, REPLY_FAILED);
  EXPECT_THAT(bad.text, HasSubstr("cannot load"));
  EXPECT_THAT(swap(0, "bad_initialize.so").text, HasSubstr("initialize() failed: "));
  expect_executing("periodic");
  device->swap(0, kComponents + "/fine.so", {},
               [](const Outcome& outcome) { EXPECT_EQ(outcome.code, REPLY_OK); });
  EXPECT_THAT(swap(0, "fine.so").text, HasSubstr("a swap of module d.periodic is still in progress"));
  run_for(milliseconds{100});
  device->command(0, Verb::stop, [](const Outcome&) {});
  ASSERT_TRUE(step_until([&] { return module_of("periodic")["state"] == "START"; }));
  const Outcome stopped = swap(0, "fine.so");
  EXPECT_EQ(stopped.code, REPLY_REFUSED);
  EXPECT_THAT(stopped.text,
              HasSubstr("d.periodic is in START; it can be swapped only in EXECUTING; run takt start "
                        "d.periodic"));
  device->command(0, Verb::destruct, [](const Outcome&) {});
  ASSERT_TRUE(step_until([&] { return module_of("periodic")["state"] == "DESTRUCT"; }));
  EXPECT_THAT(
      swap(0, "fine.so").text,
      HasSubstr("run takt reset d.periodic, then takt initialize d.periodic, then takt start d.periodic"));
  take_down();
}

TEST_F(DeviceSwap, RestoresTheOldInstanceIfTheNewOneFailsDuringItsTrial) {
  bring_up(module("ticks", "ticks.so", kEvery));
  wait_for_cycles("ticks", 20);
  const Outcome outcome = swap(0, "ticks_fails.so");
  EXPECT_EQ(outcome.code, REPLY_FAILED);
  EXPECT_THAT(outcome.text, HasSubstr("failure: the third is not for me"));
  wait_for_cycles("ticks", module_of("ticks")["cycles"].get<int>() + 50);
  expect_executing("ticks");
  EXPECT_EQ(swap(0, "ticks_more.so").code, REPLY_OK);
  take_down();
}

TEST_F(DeviceSwap, GivesOnlyTheNewInstanceTheNewValues) {
  bring_up(module("ticks", "ticks.so", kEvery));
  wait_for_cycles("ticks", 20);
  const auto label = [this] {
    std::optional<Outcome> answer;
    device->get(0, "label", [&answer](const Outcome& outcome) { answer = outcome; });
    EXPECT_TRUE(step_until([&] { return answer.has_value(); }));
    return answer.value_or(Outcome{}).value;
  };
  EXPECT_EQ(swap(0, "ticks_fails.so", {{"label", "new"}}).code, REPLY_FAILED);
  EXPECT_EQ(label(), "none") << "the old instance continues";
  EXPECT_EQ(swap(0, "ticks_more.so", {{"label", "new"}}).code, REPLY_OK);
  EXPECT_EQ(label(), "new");
  EXPECT_EQ(swap(0, "ticks_crashes.so", {{"label", "newer"}}).code, REPLY_FAILED);
  ASSERT_TRUE(step_until([&] { return module_of("ticks")["state"] == "EXECUTING"; }));
  EXPECT_EQ(label(), "new") << "the host was restarted with the present value";
  take_down();
}

TEST_F(DeviceSwap, RestoresTheOldInstanceAfterEachCrashOfTheNewOne) {
  bring_up(module("ticks", "ticks.so", kEvery) + module("other", "fine.so", kEvery));
  for (int n = 0; n < 5; ++n) {  // outside of swaps, the supervisor gives up a host that crashes this often
    ASSERT_TRUE(step_until([&] { return module_of("ticks")["state"] == "EXECUTING"; }));
    const Outcome outcome = swap(0, "ticks_crashes.so");
    EXPECT_EQ(outcome.code, REPLY_FAILED);
    EXPECT_THAT(outcome.text, HasSubstr("the old instance is loaded again"));
  }
  ASSERT_TRUE(step_until([&] { return module_of("ticks")["state"] == "EXECUTING"; }));
  ASSERT_TRUE(step_until([&] { return module_of("other")["state"] == "EXECUTING"; }));
  take_down();
}

TEST_F(DeviceSwap, DoesNotPreventTheDeviceFromStoppingIfTheNewInstanceHangs) {
  bring_up(module("ticks", "ticks.so", kEvery));
  wait_for_cycles("ticks", 20);
  std::optional<Outcome> answer;
  device->swap(0, kComponents + "/ticks_hangs.so", {},
               [&answer](const Outcome& outcome) { answer = outcome; });
  run_for(milliseconds{200});
  EXPECT_FALSE(answer);
  device->command(0, Verb::stop, [](const Outcome& outcome) { EXPECT_EQ(outcome.code, REPLY_REFUSED); });
  take_down();
}

}  // namespace
}  // namespace takt::node::device_swap_test
