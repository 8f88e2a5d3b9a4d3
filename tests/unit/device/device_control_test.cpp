// Tests properties, commands and deadlines of modules on a real device.
#include <gmock/gmock.h>
#include <signal.h>

#include <optional>

#include "real_device.hpp"

namespace takt::node::device_control_test {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;
using testing::AllOf;
using testing::HasSubstr;
using testing::MatchesRegex;

class DeviceProperties : public RealDevice {
 protected:
  Outcome command(Verb verb) {
    return wait([&](auto done) { device->command(0, verb, done); });
  }
  std::string live(const std::string& properties = "", const std::string& what = kEvery) const {
    return module("live", "live.so", what, file("live") + properties);
  }
  static std::string program(const std::string& properties = "") {
    return module("p", "program_properties.exe", kSporadic, properties,
                  R"(<recovery attempts="1" backoff="10000000"/>)") +
           module("tick", "fine.so", kEvery);
  }
  static std::string value(const std::string& name, const std::string& text) {
    return "<value name=\"" + name + "\">" + text + "</value>";
  }

  Outcome get(std::uint32_t module, const std::string& property) {
    return wait([&](auto done) { device->get(module, property, done); });
  }
  Outcome set(std::uint32_t module, const std::string& property, const std::string& text) {
    return wait([&](auto done) { device->set(module, property, text, done); });
  }
  template <class Ask>
  Outcome wait(const Ask& ask) {
    std::optional<Outcome> answer;
    ask([&answer](const Outcome& outcome) {
      EXPECT_FALSE(answer) << "answered twice";
      answer = outcome;
    });
    EXPECT_TRUE(step_until([&] { return answer.has_value(); }));
    return answer.value_or(Outcome{.code = REPLY_LATE, .text = {}});
  }
};

TEST_F(DeviceProperties, CanBeReadAndSetWhileTheModuleRuns) {
  bring_up(live(value("step", "2")));
  ASSERT_TRUE(step_until([&] { return module_of("live")["cycles"] > 20; }));
  const Outcome before = get(0, "step");
  EXPECT_EQ(before.code, REPLY_OK) << before.text;
  EXPECT_EQ(before.value, "2");
  EXPECT_EQ(before.state, lifecycle::State::executing);
  for (const int step : {5, 1000, 7}) {
    const Outcome outcome = set(0, "step", std::to_string(step));
    EXPECT_EQ(outcome.code, REPLY_OK) << outcome.text;
    EXPECT_EQ(get(0, "step").value, std::to_string(step));
    wait_for_run("live");
  }
  EXPECT_EQ(set(0, "label", "a long text in its own memory, which run() never frees").code, REPLY_OK);
  wait_for_run("live");
  take_down();
  EXPECT_EQ(seen("live")["steps"], json::array({2, 5, 1000, 7}));
  EXPECT_EQ(seen("live")["changed"], 0);
  EXPECT_THAT(seen("live")["label"].get<std::string>(), HasSubstr("its own memory"));
}

TEST_F(DeviceProperties, KeepTheirValueWhenANewOneIsRejected) {
  bring_up(live());
  const Outcome high = set(0, "step", "1001");
  EXPECT_EQ(high.code, REPLY_REFUSED);
  EXPECT_EQ(high.text, "property 'step' cannot be '1001'; it takes a whole number, 1 to 1000, in mm");
  const Outcome unknown = set(0, "stop", "1");
  EXPECT_EQ(unknown.code, REPLY_REFUSED);
  EXPECT_EQ(unknown.text, "component Live has no property 'stop'; did you mean step?");
  EXPECT_EQ(get(0, "stop").text, unknown.text);
  wait_for_run("live");
  take_down();
  EXPECT_EQ(seen("live")["steps"], json::array({1}));
}

TEST_F(DeviceProperties, CanBeSetBeforeTheFirstRun) {
  bring_up(live(), "", false);
  EXPECT_EQ(set(0, "step", "3").code, REPLY_OK);
  EXPECT_EQ(set(0, "step", "4").code, REPLY_OK);
  device->go(os::now() + milliseconds{20});
  wait_for_cycles("live", 1);
  take_down();
  EXPECT_EQ(seen("live")["steps"], json::array({4}));
}

TEST_F(DeviceProperties, CanBeSetInANonRealTimeModule) {
  bring_up(module("tick", "fine.so", kEvery) +
           live("", "<operationtype>non-real</operationtype><period>2000000</period>"));
  ASSERT_TRUE(step_until([&] { return module_of("live")["cycles"] > 5; }));
  EXPECT_EQ(set(1, "step", "9").code, REPLY_OK);
  wait_for_run("live");
  take_down();
  EXPECT_EQ(seen("live")["steps"], json::array({1, 9}));
}

TEST_F(DeviceProperties, AreReadOnlyInCModulesAndPrograms) {
  bring_up(module("c", "slow.so", kEvery, value("ns", "1000")) +
           module("p", "fine.exe", kEvery, value("every", "3")));
  EXPECT_EQ(get(0, "ns").value, "1000");
  EXPECT_EQ(get(0, "every").text,
            "the descriptor does not set property 'every' of module c; use ns or log-level");
  EXPECT_EQ(set(0, "ns", "2000").text,
            "its component is written in C and declares no properties: it reads them, except log-level, in "
            "initialize(); "
            "change the descriptor and run takt deploy --update with it, which restarts device d");
  EXPECT_EQ(get(1, "every").value, "3");
  EXPECT_EQ(get(1, "ns").code, REPLY_REFUSED);
  const Outcome refused = set(1, "every", "4");
  EXPECT_EQ(refused.code, REPLY_REFUSED);
  EXPECT_EQ(
      refused.text,
      "its program declares no properties: it gets them, except log-level, as arguments when it starts; "
      "change the descriptor and run takt deploy --update with it, which restarts device d");
  take_down();
}

TEST_F(DeviceProperties, OfAProgramThatDeclaresThemCanBeReadAndSetWhileItRuns) {
  bring_up(program(value("label", "first")));
  ASSERT_TRUE(step_until([&] { return module_of("p")["state"] == "EXECUTING"; }));
  EXPECT_EQ(get(0, "gain").value, "1.5") << "the descriptor does not set this property";
  EXPECT_EQ(get(0, "label").value, "first");
  const Outcome outcome = set(0, "gain", "2.50");
  EXPECT_EQ(outcome.code, REPLY_OK) << outcome.text;
  EXPECT_EQ(outcome.value, "2.50");
  EXPECT_EQ(get(0, "gain").value, "2.5");
  EXPECT_EQ(set(0, "label", std::string(255, 'x')).code, REPLY_OK);
  EXPECT_EQ(get(0, "label").value, std::string(255, 'x'));

  const std::pair<std::pair<std::string, std::string>, std::string> rejected[] = {
      {{"gain", "100.5"}, "property 'gain' cannot be '100.5'; it takes a number, 0 to 100, in 1/s"},
      {{"gain", "fast"}, "property 'gain' cannot be 'fast'; it takes a number, 0 to 100, in 1/s"},
      {{"gian", "1"}, "this program has no property 'gian'; did you mean gain?"},
      {{"label", std::string(256, 'x')},
       "the name of a property has at most 63 bytes, and a value that is set at most 255"},
      {{std::string(64, 'x'), "1"},
       "the name of a property has at most 63 bytes, and a value that is set at most 255"}};
  for (const auto& [request, text] : rejected) {
    const Outcome no = set(0, request.first, request.second);
    EXPECT_EQ(no.code, REPLY_REFUSED);
    EXPECT_EQ(no.text, text);
  }
  EXPECT_EQ(get(0, "gian").text, "this program has no property 'gian'; did you mean gain?");
  EXPECT_EQ(get(0, "gain").value, "2.5");
  take_down();
  EXPECT_EQ(
      get(0, "gain").text,
      "d.p is in DESTRUCT, in which its properties cannot be read; run takt reset d.p and takt initialize "
      "d.p first");
}

TEST_F(DeviceProperties, OfAProgramCanBeSetBeforeItsFirstRelease) {
  bring_up(program(), "", false);
  EXPECT_EQ(set(0, "gain", "3").code, REPLY_OK);
  EXPECT_EQ(get(0, "gain").value, "3");
  take_down();
}

TEST_F(DeviceProperties, OfAProgramAreAnsweredInTheOrderOfTheRequests) {
  bring_up(program());
  std::string answers;
  const auto note = [&answers](const Outcome& outcome) { answers += outcome.value + " "; };
  for (const char* gain : {"2", "3"}) {
    device->set(0, "gain", gain, note);
    device->get(0, "gain", note);
  }
  EXPECT_TRUE(step_until([&] { return answers.size() >= 8; }));
  EXPECT_EQ(answers, "2 2 3 3 ");
  take_down();
}

TEST_F(DeviceProperties, OfAProgramSurviveItsCrash) {
  bring_up(program());
  ASSERT_TRUE(step_until([&] { return module_of("p")["state"] == "EXECUTING"; }));
  EXPECT_EQ(set(0, "gain", "6").code, REPLY_OK);
  const int process = module_of("p")["pid"];
  ASSERT_EQ(::kill(process, SIGSTOP), 0);
  std::optional<Outcome> answer;
  device->set(0, "gain", "7", [&answer](const Outcome& outcome) { answer = outcome; });
  run_for(milliseconds{20});
  EXPECT_FALSE(answer);
  ASSERT_EQ(::kill(process, SIGKILL), 0);
  ASSERT_TRUE(step_until([&] { return answer.has_value(); }));
  EXPECT_EQ(answer->code, REPLY_FAILED);
  EXPECT_EQ(answer->text, "the program of module p has ended");
  EXPECT_EQ(get(0, "gain").text, "the program of module p is not running; try again when it is EXECUTING");
  ASSERT_TRUE(step_until([&] { return module_of("p")["state"] == "EXECUTING"; }));
  EXPECT_EQ(get(0, "gain").value, "6");
  take_down();
}

TEST_F(DeviceProperties, OfAStoppedProgramAreReportedAsFailedAndSetWhenItContinues) {
  bring_up(program());
  ASSERT_TRUE(step_until([&] { return module_of("p")["state"] == "EXECUTING"; }));
  // The node kills a program that does not take its releases. In START, the program has none.
  device->command(0, Verb::stop, [](const Outcome&) {});
  ASSERT_TRUE(step_until([&] { return module_of("p")["state"] == "START"; }));
  const int process = module_of("p")["pid"];
  ASSERT_EQ(::kill(process, SIGSTOP), 0);
  std::vector<Outcome> answers;
  const auto note = [&answers](const Outcome& outcome) { answers.push_back(outcome); };
  device->set(0, "gain", "7", note);
  device->set(0, "gain", "8", note);
  ASSERT_TRUE(step_until([&] { return answers.size() == 2; }));
  const std::string text =
      "the program of module p has not answered within 2 s: it is stopped, or gets no CPU time";
  EXPECT_EQ(answers[0].code, REPLY_FAILED);
  EXPECT_EQ(answers[0].text, text + "; the value takes effect if the program still answers");
  EXPECT_EQ(answers[1].code, REPLY_FAILED);
  EXPECT_EQ(answers[1].text, text);
  ASSERT_EQ(::kill(process, SIGCONT), 0);
  EXPECT_EQ(get(0, "gain").value, "7") << "the program did not get the second request";
  EXPECT_EQ(set(0, "gain", "9").code, REPLY_OK);
  EXPECT_EQ(get(0, "gain").value, "9");
  take_down();
}

TEST_F(DeviceProperties, TakeTheLogLevelFromTheDescriptor) {
  bring_up(live(value("log-level", "debug")) + module("c", "slow.so", kEvery, value("log-level", "warning")) +
           module("p", "fine.exe", kEvery, value("log-level", "error")) + module("q", "fine.exe", kEvery));
  EXPECT_EQ(get(0, "log-level").value, "debug");
  EXPECT_EQ(get(1, "log-level").value, "warning");
  EXPECT_EQ(get(2, "log-level").value, "error");
  EXPECT_EQ(get(3, "log-level").value, "info");
  EXPECT_EQ(set(2, "log-level", "info").value, "info");
  EXPECT_EQ(get(2, "log-level").value, "info");
  EXPECT_EQ(get(0, "log-levl").text, "component Live has no property 'log-levl'; did you mean log-level?");
  EXPECT_EQ(get(3, "log-levl").text,
            "the descriptor does not set property 'log-levl' of module q; did you mean log-level?");
  take_down();
}

TEST_F(DeviceProperties, SurviveARestartOfTheHost) {
  bring_up(live());
  EXPECT_EQ(set(0, "step", "6").code, REPLY_OK);
  run_for(milliseconds{30});
  const int host = module_of("live")["pid"];
  ASSERT_EQ(::kill(host, SIGSTOP), 0);
  std::optional<Outcome> answer;
  device->get(0, "step", [&answer](const Outcome& outcome) { answer = outcome; });
  run_for(milliseconds{20});
  EXPECT_FALSE(answer);
  ASSERT_EQ(::kill(host, SIGKILL), 0);
  ASSERT_TRUE(step_until([&] { return answer.has_value(); }));
  EXPECT_EQ(answer->code, REPLY_FAILED);
  EXPECT_EQ(answer->text, "the host of device d has ended");
  EXPECT_EQ(get(0, "step").code, REPLY_REFUSED) << "the module is being loaded again";
  ASSERT_TRUE(step_until([&] { return module_of("live")["state"] == "EXECUTING"; }));
  EXPECT_EQ(get(0, "step").value, "6");
  take_down();
}

TEST_F(DeviceProperties, CanBeCorrectedAfterAValueThatInitializeRejects) {
  bring_up(module("live", "cpp_fails.so", kEvery, value("after", "1000000")));
  EXPECT_EQ(set(0, "initializable", "false").code, REPLY_OK);
  EXPECT_EQ(command(Verb::destruct).code, REPLY_OK);
  EXPECT_EQ(command(Verb::reset).code, REPLY_OK);
  EXPECT_EQ(command(Verb::initialize).text,
            "it went to DESTRUCT: initialize() failed: initialize() failed as it was asked to; to start it "
            "again, run takt restart d.live, which keeps what takt set has set: initializable; to change it "
            "before, "
            "run takt reset d.live and takt set d.live initializable VALUE");
  EXPECT_EQ(set(0, "initializable", "true").text,
            "d.live is in DESTRUCT, in which its properties cannot be set; run takt reset d.live first");
  EXPECT_EQ(command(Verb::reset).code, REPLY_OK);
  EXPECT_EQ(set(0, "initializable", "true").code, REPLY_OK);
  EXPECT_EQ(get(0, "initializable").text,
            "live is in IDLE; its properties can be read once it is in INITIALIZE");
  for (const Verb verb : {Verb::initialize, Verb::start}) EXPECT_EQ(command(verb).text, "");
  EXPECT_EQ(get(0, "initializable").value, "true");
  device->stop();
  ASSERT_TRUE(step_until([&] { return device->phase() == Supervisor::Phase::ended; }));
}

TEST_F(DeviceProperties, OfAProgramCanBeCorrectedInIdleBeforeTheProgramStartsAgain) {
  bring_up(program());
  for (const Verb verb : {Verb::destruct, Verb::reset}) EXPECT_EQ(command(verb).text, "");
  EXPECT_EQ(set(0, "gain", "1000").code, REPLY_OK) << "no program runs that could check the value";
  EXPECT_THAT(command(Verb::initialize).text, AllOf(HasSubstr("property 'gain' cannot be '1000'"),
                                                    HasSubstr("run takt reset d.p and takt set d.p gain")));
  EXPECT_EQ(command(Verb::reset).text, "");
  EXPECT_EQ(set(0, "gain", "4").code, REPLY_OK);
  for (const Verb verb : {Verb::initialize, Verb::start}) EXPECT_EQ(command(verb).text, "");
  EXPECT_EQ(get(0, "gain").value, "4");
  device->stop();
  ASSERT_TRUE(step_until([&] { return device->phase() == Supervisor::Phase::ended; }));
}

TEST_F(DeviceProperties, AreNamedWhenAModuleIsGivenUpAfterTheyWereSet) {
  bring_up(module("live", "cpp_fails.so", kEvery, value("after", "1000000"),
                  R"(<recovery attempts="1" backoff="0"/>)"));
  EXPECT_EQ(set(0, "recoverable", "false").code, REPLY_OK);
  EXPECT_EQ(set(0, "after", "1").code, REPLY_OK);
  ASSERT_TRUE(step_until([&] { return module_of("live")["state"] == "DESTRUCT"; }));
  EXPECT_EQ(
      module_of("live")["text"],
      "after 1 attempt: recover() failed: recover() failed as it was asked to; to start it again, run takt "
      "restart d.live, which keeps what takt set has set: after, recoverable; to change it before, run takt "
      "reset d.live and takt set d.live PROPERTY VALUE");
  EXPECT_EQ(
      device->standing().faulty,
      "module live is in DESTRUCT: after 1 attempt: recover() failed: recover() failed as it was asked to")
      << "the remedy stands only with the module";
  device->stop();
  ASSERT_TRUE(step_until([&] { return device->phase() == Supervisor::Phase::ended; }));
}

class DeviceCommands : public RealDevice {
 protected:
  /// Returns the XML of a module that has its own host and crashes in its first run.
  static std::string crashes() {
    return R"(<executor name="own" host="own"/>)" +
           module("culprit", "segv.so", kEvery, R"(<value name="after">1</value>)",
                  R"(<executor>own</executor><recovery attempts="1" backoff="10000000"/>)");
  }
  Outcome send(Verb verb) {
    std::optional<Outcome> answer;
    device->command(0, verb, [&answer](const Outcome& outcome) { answer = outcome; });
    EXPECT_TRUE(step_until([&] { return answer.has_value(); }));
    return answer.value_or(Outcome{.code = REPLY_LATE, .text = {}});
  }
  bool comes_to(const std::string& name, const std::string& state) {
    return step_until([&] { return module_of(name)["state"] == state; });
  }
  std::string story() const {
    std::string words;
    for (const Step& step : steps) words += std::string{lifecycle::to_text(step.transition.to)} + " ";
    return words;
  }
};

TEST_F(DeviceCommands, FailIfTheModuleCrashesInItsFirstRun) {
  bring_up(crashes());
  ASSERT_TRUE(comes_to("culprit", "DESTRUCT"));
  EXPECT_EQ(send(Verb::reset).code, REPLY_OK);
  EXPECT_EQ(send(Verb::initialize).code, REPLY_OK);
  steps.clear();
  const Outcome start = send(Verb::start);
  EXPECT_EQ(start.code, REPLY_FAILED);
  EXPECT_EQ(start.state, lifecycle::State::recover);
  EXPECT_THAT(start.text, MatchesRegex("it went to RECOVER: crash: the host of executor own was killed by "
                                       "SIGSEGV \\(Segmentation fault\\) in run\\(\\), in .* in segv.so; "
                                       "its recovery continues, with target state EXECUTING"));
  ASSERT_TRUE(comes_to("culprit", "DESTRUCT"));
  EXPECT_EQ(story(), "START EXECUTING RECOVER EXECUTING RECOVER DESTRUCT ");
}

TEST_F(DeviceCommands, LeaveAModuleStoppedOnlyAfterAStop) {
  bring_up(module("tick", "fine.so", kEvery), "", false);
  ASSERT_TRUE(comes_to("tick", "START"));
  EXPECT_FALSE(module_of("tick").contains("stopped")) << "it waits for its first release";
  device->go(os::now() + milliseconds{20});
  ASSERT_TRUE(comes_to("tick", "EXECUTING"));
  EXPECT_EQ(send(Verb::stop).code, REPLY_OK);
  EXPECT_EQ(module_of("tick")["state"], "START");
  EXPECT_EQ(module_of("tick")["stopped"], true);
  EXPECT_EQ(send(Verb::start).code, REPLY_OK);
  EXPECT_FALSE(module_of("tick").contains("stopped"));
  take_down();
}

TEST_F(DeviceCommands, SayThatAComponentIsNotLoadedYetAfterACrash) {
  bring_up(R"(<executor name="own" host="own"/>)" +
           module("culprit", "segv.so", kEvery, R"(<value name="after">1</value>)",
                  R"(<executor>own</executor><recovery attempts="1" backoff="60000000000"/>)"));
  ASSERT_TRUE(comes_to("culprit", "RECOVER"));
  std::optional<Outcome> answer;
  device->set(0, "after", "2", [&answer](const Outcome& outcome) { answer = outcome; });
  ASSERT_TRUE(step_until([&] { return answer.has_value(); }));
  EXPECT_EQ(
      answer->text,
      "its host has crashed, and its component is not loaded again yet; try again when it is EXECUTING");
  EXPECT_EQ(send(Verb::destruct).code, REPLY_OK);
  take_down();
}

TEST_F(DeviceCommands, FailIfTheHostIsKilledBeforeItAnswers) {
  bring_up(module("live", "live.so", kEvery, file("live")));
  ASSERT_TRUE(comes_to("live", "EXECUTING"));
  for (const Verb verb : {Verb::stop, Verb::destruct, Verb::reset}) ASSERT_EQ(send(verb).code, REPLY_OK);
  const int host = module_of("live")["pid"];
  ASSERT_EQ(::kill(host, SIGSTOP), 0);
  std::optional<Outcome> answer;
  device->command(0, Verb::initialize, [&answer](const Outcome& outcome) { answer = outcome; });
  run_for(milliseconds{20});
  EXPECT_FALSE(answer);
  ASSERT_EQ(::kill(host, SIGKILL), 0);
  ASSERT_TRUE(step_until([&] { return answer.has_value(); }));
  EXPECT_EQ(answer->code, REPLY_FAILED);
  EXPECT_EQ(answer->text,
            "the host was killed by SIGKILL (Killed); it is loaded again and goes to INITIALIZE");
  ASSERT_TRUE(comes_to("live", "INITIALIZE"));
  run_for(milliseconds{50});
  EXPECT_EQ(module_of("live")["state"], "INITIALIZE");
  take_down();
}

class DeviceDeadlines : public RealDevice {
 protected:
  /// Returns the XML of a sporadic module that has a deadline of 5 ms, but takes 20 ms once in 50 rows.
  static std::string late(const std::string& file, const std::string& miss, const std::string& recovery) {
    return module("late", file,
                  "<operationtype>sporadic</operationtype><deadline miss=\"" + miss + "\">5000000</deadline>",
                  "<value name=\"every\">50</value><value name=\"ns\">20000000</value>", recovery);
  }
  std::string with_tick(const std::string& module_text) const {
    return module("tick", "fine.so", kEvery) + module_text;
  }
  std::string story() const {
    std::string words;
    for (const Step& step : steps) {
      if (step.module == 1) words += std::string{lifecycle::to_text(step.transition.to)} + " ";
    }
    return words;
  }
};

TEST_F(DeviceDeadlines, AreCountedWhenMissed) {
  for (const std::string file : {"fine_sporadic.so", "fine_sporadic.exe"}) {
    SCOPED_TRACE(file);
    steps.clear();
    bring_up(with_tick(late(file, "count", "")));
    ASSERT_TRUE(step_until([&] { return module_of("late")["overruns"] >= 2; }));
    EXPECT_EQ(story(), "INITIALIZE START EXECUTING ");
    EXPECT_EQ(module_of("late")["errors"], 0);
    take_down();
  }
}

TEST_F(DeviceDeadlines, RaiseAnErrorWhenMissedIfTheDescriptorSaysSo) {
  for (const std::string file : {"fine_sporadic.so", "fine_sporadic.exe"}) {
    SCOPED_TRACE(file);
    steps.clear();
    bring_up(with_tick(late(file, "error", R"(<recovery attempts="2" backoff="10000000"/>)")));
    ASSERT_TRUE(step_until([&] { return module_of("late")["state"] == "EXECUTING"; }));
    const int pid = module_of("late")["pid"];
    ASSERT_TRUE(step_until([&] { return module_of("late")["state"] == "DESTRUCT"; }));
    EXPECT_EQ(story(), "INITIALIZE START EXECUTING RECOVER EXECUTING RECOVER EXECUTING RECOVER DESTRUCT ")
        << "both recovery attempts succeed, but the module soon fails again";
    EXPECT_EQ(module_of("late")["pid"], pid) << "a late program is not restarted";
    EXPECT_EQ(module_of("late")["errors"], 3);
    for (const Step& step : steps) {
      if (step.transition.event != lifecycle::Event::error) continue;
      EXPECT_EQ(step.error, ErrorType::deadline);
      EXPECT_THAT(step.text, HasSubstr("after its deadline"));
    }
    device->stop();
    ASSERT_TRUE(step_until([&] { return device->phase() == Supervisor::Phase::ended; }));
  }
}

}  // namespace
}  // namespace takt::node::device_control_test
