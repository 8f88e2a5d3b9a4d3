// Tests, between several processes, the topics on which nodes publish their state.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <takt/wire/taktPubSubTypes.h>
#include <takt/dds/topics.hpp>
#include <takt/wire/validation.hpp>
#include "workarounds/checked_type.hpp"

#include "domain.hpp"
#include "peer.hpp"

namespace takt::dds_test::topics_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

std::shared_ptr<dds::Participant> participate() {
  auto made = dds::Participant::create(on_loopback("test"));
  EXPECT_TRUE(made.ok()) << to_text(made.problems());
  return made.ok() ? *made : nullptr;
}

/// Records the last sequence number received for each path.
class Received {
  template <class F>
  auto with(F f) const {
    const std::lock_guard lock{mutex_};
    return f();
  }

 public:
  dds::Callbacks<LifecycleStatus> listener() {
    return {.sample =
                [this](const LifecycleStatus& status, wire::WriterId) {
                  const std::lock_guard lock{mutex_};
                  std::uint64_t& last = last_[status.path().to_string()];
                  if (status.sequence_number() <= last) ++doubled_;
                  if (status.sequence_number() > last + 1) gaps_ += status.sequence_number() - last - 1;
                  last = status.sequence_number();
                  ++samples_;
                  if (samples_ == held_up_at_) std::this_thread::sleep_for(1s);
                },
            .disposed =
                [this](const LifecycleStatus& key, wire::WriterId) {
                  const std::lock_guard lock{mutex_};
                  last_.erase(key.path().to_string());
                }};
  }
  /// Makes the reader sleep for a second when it receives the `sample`-th sample.
  void hold_up(std::size_t sample) {
    const std::lock_guard lock{mutex_};
    held_up_at_ = sample;
  }
  std::size_t keys() const {
    return with([this] { return last_.size(); });
  }
  std::size_t samples() const {
    return with([this] { return samples_; });
  }
  std::size_t doubled() const {
    return with([this] { return doubled_; });
  }
  std::size_t gaps() const {
    return with([this] { return gaps_; });
  }
  std::set<std::uint64_t> last() const {
    return with([this] {
      std::set<std::uint64_t> all;
      for (const auto& [path, number] : last_) all.insert(number);
      return all;
    });
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::uint64_t> last_;
  std::size_t samples_ = 0;
  std::size_t doubled_ = 0;
  std::size_t gaps_ = 0;
  std::size_t held_up_at_ = 0;
};

TEST(LifecycleTopic, GivesALateReaderTheCurrentStatesOfThreeHundredModules) {
  Peer writer{{"state", "300"}};
  ASSERT_EQ(writer.line(), "failures 0");
  Received received;
  auto reader = dds::Reader<LifecycleStatus>::create(participate(), received.listener());
  ASSERT_TRUE(reader.ok());
  EXPECT_TRUE(soon([&] { return received.keys() == 300; })) << received.keys();
  EXPECT_EQ(received.last(), std::set<std::uint64_t>{2}) << "the last state of each module, not the first";
  EXPECT_EQ(received.samples(), 300U);
}

TEST(LifecycleTopic, DoesNotGiveALateReaderDisposedStates) {
  Peer writer{{"state", "20"}};
  ASSERT_EQ(writer.line(), "failures 0");
  auto participant = participate();
  Received received;
  auto reader = dds::Reader<LifecycleStatus>::create(participant, received.listener());
  ASSERT_TRUE(soon([&] { return received.keys() == 20; }));
  writer.write("dispose");
  EXPECT_TRUE(soon([&] { return received.keys() == 0; }));
  Received late;
  auto later = dds::Reader<LifecycleStatus>::create(participant, late.listener());
  ASSERT_TRUE(soon([&] { return later->matched() == 1; }));
  std::this_thread::sleep_for(300ms);
  EXPECT_EQ(late.samples(), 0U);
}

TEST(LifecycleTopic, NotifiesAReaderOfDisposedInstancesWithKeysOfAnyLength) {
  Peer writer{{"keys", "40"}};
  ASSERT_EQ(writer.line(), "ready");
  Received received;
  auto reader = dds::Reader<LifecycleStatus>::create(participate(), received.listener());
  ASSERT_TRUE(soon([&] { return received.keys() == 40; })) << received.keys();
  writer.write("dispose");
  EXPECT_TRUE(soon([&] { return received.keys() == 0; })) << received.keys() << " of 40 keys are still alive";
}

TEST(LifecycleTopic, DeliversEachOfTenThousandTransitionsOnceUnderLoad) {
  std::atomic<bool> ending{false};
  std::vector<std::thread> load;
  for (unsigned i = 0; i < std::thread::hardware_concurrency(); ++i)
    load.emplace_back([&ending] {
      while (!ending) continue;
    });
  Received received;
  auto reader = dds::Reader<LifecycleStatus>::create(participate(), received.listener());
  ASSERT_TRUE(reader.ok());
  Peer writer{{"transitions", "20", "10000"}};
  ASSERT_TRUE(writer.prints("ready"));
  ASSERT_TRUE(soon([&] { return received.samples() == 20; }))
      << "the reader must match before the load begins";
  received.hold_up(1000);  // a writer that did not wait would overflow the reader's socket in this second
  const auto begin = Clock::now();
  writer.write("go");
  EXPECT_EQ(writer.line(2 * long_enough()), "written; failures 0, timeouts 0");
  EXPECT_TRUE(soon([&] { return received.samples() == 10000; })) << received.samples();
  std::cout << "10,000 transitions in " << std::chrono::duration<double>(Clock::now() - begin).count()
            << " s\n";
  EXPECT_EQ(received.gaps(), 0U);
  EXPECT_EQ(received.doubled(), 0U);
  ending = true;
  for (std::thread& each : load) each.join();
}

/// Records when each writer of device states becomes alive and when it is lost.
class Devices {
 public:
  dds::Callbacks<DeviceStatus> listener() {
    return {.sample =
                [this](const DeviceStatus& status, wire::WriterId writer) {
                  const std::lock_guard lock{mutex_};
                  names_[writer] = status.device().to_string();
                  ++samples_[names_[writer]];
                },
            .lost = [this](wire::WriterId writer) { note(writer, "lost"); },
            .alive = [this](wire::WriterId writer) { note(writer, "alive"); }};
  }
  /// Returns the recorded events of the device in their order, such as "alive lost alive".
  std::string events(const std::string& device) const {
    const std::lock_guard lock{mutex_};
    std::string all;
    for (const auto& [writer, what] : events_) {
      if (names_.count(writer) > 0 && names_.at(writer) == device) all += (all.empty() ? "" : " ") + what;
    }
    return all;
  }
  std::size_t samples(const std::string& device) const {
    const std::lock_guard lock{mutex_};
    return samples_.count(device) == 0 ? 0 : samples_.at(device);
  }

 private:
  void note(wire::WriterId writer, const std::string& what) {
    const std::lock_guard lock{mutex_};
    events_.emplace_back(writer, what);
  }
  mutable std::mutex mutex_;
  std::map<wire::WriterId, std::string> names_;
  std::map<std::string, std::size_t> samples_;
  std::vector<std::pair<wire::WriterId, std::string>> events_;
};

TEST(Device, IsReportedLostWithinItsLeaseAfterItIsKilled) {
  auto participant = participate();
  Devices devices;
  auto reader = dds::Reader<DeviceStatus>::create(participant, devices.listener());
  Peer other{{"device", "other"}};
  ASSERT_TRUE(soon([&] { return devices.samples("other") > 0; }));
  std::vector<double> seconds;
  // Repeats the measurement if it took too long, because the machine may have stalled.
  for (int attempt = 0; attempt < 5 && (seconds.empty() || seconds.back() > 0.4); ++attempt) {
    const std::string name = "mortal" + std::to_string(attempt);
    Peer mortal{{"device", name}};
    ASSERT_TRUE(soon([&] { return devices.samples(name) >= 5; }));
    mortal.signal(SIGKILL);
    const auto killed = Clock::now();
    ASSERT_TRUE(soon([&] { return devices.events(name) == "alive lost"; }, 2s)) << devices.events(name);
    seconds.push_back(std::chrono::duration<double>(Clock::now() - killed).count());
    std::cout << "reported after " << seconds.back() << " s\n";
  }
  EXPECT_LE(seconds.back(), 0.4);
  EXPECT_EQ(devices.events("other"), "alive") << "the other device continues";
  std::this_thread::sleep_for(4s);  // the DDS lease of the killed process expires in this time, too
  EXPECT_EQ(devices.events("mortal0"), "alive lost") << "the loss is reported once";
}

TEST(Device, IsReportedLostWhenItHangsAndAliveWhenItContinues) {
  Devices devices;
  auto reader = dds::Reader<DeviceStatus>::create(participate(), devices.listener());
  Peer peer{{"device", "d"}};
  ASSERT_TRUE(soon([&] { return devices.samples("d") >= 3; }));
  peer.signal(SIGSTOP);
  ASSERT_TRUE(soon([&] { return devices.events("d").ends_with("lost"); })) << devices.events("d");
  peer.signal(SIGCONT);
  EXPECT_TRUE(soon([&] { return devices.events("d").ends_with("lost alive"); })) << devices.events("d");
}

TEST(Device, IsFoundAgainAfterItsParticipantWasLostOnOneSideOnly) {
  Devices devices;
  auto reader = dds::Reader<DeviceStatus>::create(participate(), devices.listener());
  Peer peer{{"returning", "d"}};
  ASSERT_TRUE(soon([&] { return devices.samples("d") >= 3; }));
  peer.signal(SIGSTOP);
  ASSERT_TRUE(soon([&] { return reader->matched() == 0; })) << "the lease is 3 s";
  peer.signal(SIGCONT);
  EXPECT_TRUE(soon([&] { return reader->matched() == 1; }));
  EXPECT_TRUE(soon([&] { return devices.events("d").ends_with("lost alive"); })) << devices.events("d");
}

TEST(Device, IsReportedLostWhenItLeaves) {
  Devices devices;
  auto reader = dds::Reader<DeviceStatus>::create(participate(), devices.listener());
  Peer peer{{"device", "d"}};
  ASSERT_TRUE(soon([&] { return devices.samples("d") >= 1; }));
  peer.write("end");
  EXPECT_TRUE(soon([&] { return devices.events("d").ends_with("lost"); })) << devices.events("d");
}

TEST(DeviceTopic, IsAcknowledgedAtOnceIfTheWriterWaitsForIt) {
  auto writer = dds::Writer<DeviceStatus>::create(participate());
  ASSERT_TRUE(writer.ok());
  DeviceStatus status;
  status.path("test/d");
  status.cell("test");
  status.device("d");
  status.node("n");
  Peer peer{{"watch"}};
  // Without a question, readers acknowledge once a second. So most waits would take longer than 200 ms.
  int quick = 0;
  EXPECT_TRUE(soon([&] {
    status.sequence_number(status.sequence_number() + 1);
    writer->write(status);
    const bool received = peer.prints("d " + std::to_string(status.sequence_number()), 200ms);
    quick = writer->wait_acknowledged(200ms) && received ? quick + 1 : 0;
    return quick == 10;
  }));
}

TEST(DeviceTopic, DeliversValidSamplesDespiteThousandsOfForgedOnes) {
  Devices devices;
  auto reader = dds::Reader<DeviceStatus>::create(participate(), devices.listener());
  DeviceStatus status;
  status.path("test/d");
  status.cell("test");
  status.device("d");
  status.node("n");
  status.text("well");
  Peer forger{{"forge", "takt/device", "takt::DeviceStatus", "keyed", "3000",
               in_hex<DeviceStatusPubSubType>(status)}};
  ASSERT_TRUE(forger.prints("forged"));
  EXPECT_GT(reader->refused(), 1000U);
  Peer honest{{"device", "honest"}};
  EXPECT_TRUE(soon([&] { return devices.samples("honest") > 0; }));
}

TEST(Validation, RejectsADeviceStatusOrCommandWithInvalidFields) {
  DeviceStatus good;
  good.path("c/d");
  good.cell("c");
  good.device("d");
  good.node("n");
  DeviceStatus status = good;
  EXPECT_TRUE(wire::validate(status));
  status.state(static_cast<DeviceState>(17));
  EXPECT_FALSE(wire::validate(status));
  status = good;
  status.device("");
  EXPECT_FALSE(wire::validate(status));
  status = good;
  status.device("a\x1b[2Jb");
  EXPECT_FALSE(wire::validate(status));
  status = good;
  status.cell("\xff");
  EXPECT_FALSE(wire::validate(status));
  status = good;
  status.text("it broke: \xff\x1b[31m \xc3\xa4");
  EXPECT_TRUE(wire::validate(status));
  EXPECT_EQ(status.text().to_string(), "it broke: ? [31m \xc3\xa4");

  Command command;
  command.id("1");
  command.device("d");
  command.parts(1);
  EXPECT_TRUE(wire::validate(command));
  command.part(1);
  EXPECT_FALSE(wire::validate(command));
  command.part(0);
  command.parts(0);
  EXPECT_FALSE(wire::validate(command));
  command.parts(1);
  command.kind(static_cast<CommandKind>(99));
  EXPECT_FALSE(wire::validate(command));
}

TEST(InstanceKeys, AreCorrectWhenTwoThreadsComputeThemAtTheSameTime) {
  dds::CheckedType<LifecycleStatusPubSubType> type;
  const auto key_of = [&type](const std::string& path) {
    LifecycleStatus status;
    status.path(path);
    return dds::number_of(dds::key_of_sample(type, &status));
  };
  const std::string one = "cell/device/one";
  const std::string other = "cell/another_device_with_a_long_name/other_module";
  const auto expected = std::make_pair(key_of(one), key_of(other));
  std::atomic<int> wrong{0};
  std::thread first{[&] {
    for (int i = 0; i < 100'000; ++i) wrong += key_of(one) == expected.first ? 0 : 1;
  }};
  std::thread second{[&] {
    for (int i = 0; i < 100'000; ++i) wrong += key_of(other) == expected.second ? 0 : 1;
  }};
  first.join();
  second.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace takt::dds_test::topics_test
