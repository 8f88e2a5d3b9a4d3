#include <takt/model/alarm.hpp>

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include <takt/model/json.hpp>

namespace takt::model::alarm_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class AlarmsOfADevice : public testing::Test {
 protected:
  void event(FaultKind kind, const std::string& module, const std::string& cause = "cause") {
    faults_.push_back({.sequence = faults_.size() + 1,
                       .time_ns = static_cast<std::int64_t>(faults_.size() + 1) * 100,
                       .cell = "cell",
                       .device = "robot",
                       .module = module,
                       .kind = kind,
                       .cause = cause});
    alarms_.take(faults_.back());
  }
  void acknowledge(const std::string& module = "", const std::string& note = "") {
    for (const Alarm& alarm : alarms_.unacknowledged(module))
      event(FaultKind::acknowledged, alarm.module, acknowledgement_text(alarm, "anna", note));
  }
  void become(bool faulty) {
    alarms_.update([faulty](const std::string&) { return faulty; },
                   [](const std::string& device) { return device != "removed"; });
  }
  [[nodiscard]] std::vector<std::string> states() const {
    std::vector<std::string> list;
    for (const Alarm& alarm : alarms_.all())
      list.push_back(alarm.module + " " + to_text(alarm.kind) + ": " + state_of(alarm));
    return list;
  }

  std::vector<Fault> faults_;
  Alarms alarms_;
};

TEST_F(AlarmsOfADevice, PassThroughTheFourStatesOfTheStandard) {
  event(FaultKind::error, "servo");
  EXPECT_THAT(states(), ElementsAre("servo error: unacknowledged"));
  acknowledge();
  EXPECT_THAT(states(), ElementsAre("servo error: acknowledged"));
  EXPECT_EQ(alarms_.all()[0].acknowledged, (Acknowledgement{"anna", "", 200}));
  become(false);
  EXPECT_THAT(states(), IsEmpty()) << "normal";
  event(FaultKind::error, "servo");
  become(false);
  EXPECT_THAT(states(), ElementsAre("servo error: unacknowledged, returned to normal"));
  acknowledge();
  EXPECT_THAT(states(), IsEmpty());
}

TEST_F(AlarmsOfADevice, AreRaisedByErrorsAndStaleInputsOnly) {
  for (std::size_t i = 0; i < kFaultKinds; ++i) {
    const auto kind = static_cast<FaultKind>(i);
    Alarms alarms;
    alarms.take(
        {.sequence = 1, .device = "robot", .module = "servo", .kind = kind, .cause = "input 'a' is old"});
    const bool raises =
        kind == FaultKind::stale_input ||
        (severity_of(kind) == Severity::error && kind != FaultKind::not_recovered && !is_log_line(kind));
    EXPECT_EQ(alarms.all().size(), raises ? 1U : 0U) << to_text(kind);
  }
}

TEST_F(AlarmsOfADevice, CountRepetitionsUnderTheNumberThatTheOperatorHasSeen) {
  event(FaultKind::stale_input, "servo", "the newest value of input 'a' is older than its deadline");
  event(FaultKind::fresh_input, "servo", "input 'a' has new values");
  event(FaultKind::stale_input, "servo", "the newest value of input 'a' is older than its deadline");
  ASSERT_THAT(alarms_.all(), SizeIs(1));
  EXPECT_EQ(alarms_.all()[0].count, 2U);
  EXPECT_EQ(alarms_.all()[0].since_ns, 100);
  EXPECT_EQ(alarms_.all()[0].last_ns, 300);
  EXPECT_THAT(alarms_.unacknowledged("servo", 1), SizeIs(1));
}

TEST_F(AlarmsOfADevice, KeepAWorseFaultThatTheOperatorHasNotSeen) {
  event(FaultKind::error, "servo");
  event(FaultKind::given_up, "servo");
  EXPECT_THAT(states(), ElementsAre("servo given-up: unacknowledged"));
  EXPECT_THAT(alarms_.unacknowledged("servo", 1), IsEmpty());
  EXPECT_THAT(alarms_.unacknowledged("servo", 2), SizeIs(1));
}

TEST_F(AlarmsOfADevice, MustBeAcknowledgedAgainAfterANewFault) {
  event(FaultKind::error, "servo");
  acknowledge();
  event(FaultKind::given_up, "servo");
  EXPECT_THAT(states(), ElementsAre("servo given-up: unacknowledged"));
  EXPECT_EQ(alarms_.all()[0].since_ns, 300);
}

TEST_F(AlarmsOfADevice, AreSeparateForEachInputAndEachLostDevice) {
  event(FaultKind::stale_input, "servo", "the newest value of input 'a' is older than its deadline");
  event(FaultKind::stale_input, "servo", "the newest value of input 'b' is older than its deadline");
  event(FaultKind::device_lost, "", "device line is lost: nothing arrives from its node");
  event(FaultKind::device_lost, "", "device door is lost: nothing arrives from its node");
  event(FaultKind::fresh_input, "servo", "input 'b' has new values");
  event(FaultKind::device_back, "", "device line is back");
  EXPECT_THAT(states(), ElementsAre("servo stale-input: unacknowledged",
                                    "servo stale-input: unacknowledged, returned to normal",
                                    " device-lost: unacknowledged, returned to normal",
                                    " device-lost: unacknowledged"));
  EXPECT_TRUE(alarms_.is_lost("door"));
  EXPECT_FALSE(alarms_.is_lost("line"));
  event(FaultKind::undeployed, "");
  EXPECT_FALSE(alarms_.is_lost("door"));
  EXPECT_THAT(alarms_.needed(), ElementsAre(1, 2, 3, 4));
}

TEST_F(AlarmsOfADevice, AcknowledgeOneModuleOrAll) {
  event(FaultKind::error, "servo");
  event(FaultKind::error, "arm");
  event(FaultKind::host_restart, "");
  acknowledge("arm");
  EXPECT_THAT(states(), ElementsAre("servo error: unacknowledged", "arm error: acknowledged",
                                    " host-restart: unacknowledged, returned to normal"));
  acknowledge();
  EXPECT_THAT(states(), ElementsAre("servo error: acknowledged", "arm error: acknowledged"));
}

TEST_F(AlarmsOfADevice, AreTheSameAfterARestartOfTheNode) {
  event(FaultKind::error, "servo");
  acknowledge("servo", "replaced: the cable");
  become(false);
  event(FaultKind::error, "servo", "again");
  event(FaultKind::host_restart, "");
  event(FaultKind::device_lost, "", "device line is lost: nothing arrives from its node");
  acknowledge("", "");
  event(FaultKind::given_up, "arm");
  event(FaultKind::node_end, "");
  event(FaultKind::node_start, "");
  Alarms restarted;
  for (const Fault& fault : faults_) restarted.take(fault);
  EXPECT_EQ(restarted.all(), alarms_.all());
  EXPECT_THAT(states(),
              ElementsAre(" device-lost: acknowledged", "arm given-up: unacknowledged, returned to normal"));
}

TEST_F(AlarmsOfADevice, ForgetTheOldestIfThereAreTooMany) {
  event(FaultKind::error, "first");
  event(FaultKind::error, "second");
  acknowledge("second");
  for (std::size_t i = 2; i < Alarms::kMost; ++i) event(FaultKind::error, "m" + std::to_string(i));
  EXPECT_THAT(alarms_.all(), SizeIs(Alarms::kMost));
  event(FaultKind::error, "another");
  EXPECT_EQ(alarms_.all()[0].module, "first") << "the acknowledged one is forgotten first";
  event(FaultKind::error, "one more");
  EXPECT_EQ(alarms_.all()[0].module, "m2");
  EXPECT_THAT(alarms_.all(), SizeIs(Alarms::kMost));
}

TEST_F(AlarmsOfADevice, AreListedWorstFirst) {
  event(FaultKind::error, "acknowledged");
  acknowledge();
  event(FaultKind::host_restart, "past");
  event(FaultKind::stale_input, "stale", "the newest value of input 'a' is older than its deadline");
  event(FaultKind::error, "older");
  event(FaultKind::error, "newer");
  std::vector<Alarm> all = alarms_.all();
  std::ranges::sort(all, is_worse);
  std::vector<std::string> modules;
  for (const Alarm& alarm : all) modules.push_back(alarm.module);
  EXPECT_THAT(modules, ElementsAre("newer", "older", "stale", "past", "acknowledged"));
}

TEST_F(AlarmsOfADevice, ReturnToNormalWhenALostDeviceIsRemovedFromTheCell) {
  event(FaultKind::device_lost, "", "device line is lost: nothing arrives from its node");
  event(FaultKind::device_lost, "", "device removed has left");
  become(false);
  EXPECT_THAT(states(), ElementsAre(" device-lost: unacknowledged",
                                    " device-lost: unacknowledged, returned to normal"));
}

TEST_F(AlarmsOfADevice, ConvertToJsonAndBack) {
  event(FaultKind::error, "servo", "it \"fell\"");
  event(FaultKind::device_lost, "", "device line is lost");
  acknowledge("servo", "a note");
  EXPECT_EQ(alarms_from(to_json(alarms_.all())), alarms_.all());
  EXPECT_FALSE(alarms_from(parse_json(R"([{"device": "robot"}])")));
  EXPECT_FALSE(alarms_from(parse_json("{}")));
  EXPECT_FALSE(alarms_from(parse_json("nonsense")));
}

std::string problem_of(const std::string& data) {
  const auto read = acknowledge_from(data);
  return read ? "" : read.problems()[0].what;
}

TEST(Acknowledging, RejectsDataThatAreNotValid) {
  EXPECT_EQ(problem_of(R"({"note": "fine", "alarm": 7})"), "");
  EXPECT_THAT(problem_of(""), HasSubstr("it is not a JSON object"));
  EXPECT_THAT(problem_of(R"({"alarm": -1})"), HasSubstr("member 'alarm'"));
  EXPECT_THAT(problem_of(R"({"alarm": 1.5})"), HasSubstr("member 'alarm'"));
  EXPECT_THAT(problem_of(R"({"module": "x"})"), HasSubstr("member 'module'"));
  EXPECT_EQ(problem_of(R"({"note": ")" + std::string(255, 'x') + R"("})"), "");
  EXPECT_EQ(problem_of(R"({"note": ")" + std::string(256, 'x') + R"("})"),
            "the acknowledgement is not valid: the note has 256 bytes, but may have at most 255");
}

TEST(Acknowledging, WritesTheNoteOnOneLine) {
  const Alarm alarm{.number = 17, .kind = FaultKind::given_up};
  EXPECT_EQ(acknowledgement_text(alarm, "anna", ""), "alarm 17 (given-up) acknowledged by anna");
  EXPECT_EQ(acknowledgement_text(alarm, "anna", "a\nb\x1b[2J: c"),
            "alarm 17 (given-up) acknowledged by anna: a\\nb\\x1b[2J: c");
}

}  // namespace
}  // namespace takt::model::alarm_test
