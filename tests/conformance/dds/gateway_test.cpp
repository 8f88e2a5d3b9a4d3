// Tests the gateway, which moves samples between a device's links and DDS. At the other end of DDS is another
// process (peer.cpp) or a second link.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <takt/wire/takt.h>
#include <takt/wire/taktPubSubTypes.h>
#include <takt/channel/link.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/dds/topics.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>

#include "domain.hpp"
#include "peer.hpp"
#include "sample.hpp"

namespace takt::dds_test::gateway_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// Memory that contains a link, formatted as the node formats it.
/// The memory of a link. It exists until the fixture has destroyed the gateway, which reads all links.
class Memory {
 public:
  explicit Memory(channel::Link::Options options) : size_(channel::Link::layout(options).size()) {
    bytes_ = static_cast<std::byte*>(::operator new (size_, std::align_val_t{64}));
    const std::lock_guard lock{mutex_};
    all_.emplace_back(bytes_);
    std::memset(bytes_, 0, size_);
    channel::Link::format(bytes_, options);
  }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  static void free_all() { all_.clear(); }
  [[nodiscard]] channel::Link link() const { return channel::Link{bytes_}; }

 private:
  struct Free {
    void operator()(std::byte* bytes) const { ::operator delete (bytes, std::align_val_t{64}); }
  };
  static inline std::mutex mutex_;
  static inline std::vector<std::unique_ptr<std::byte, Free>> all_;
  std::size_t size_;
  std::byte* bytes_;
};

constexpr std::uint32_t kPayload = kMostData + 64;

channel::Link::Options queue(std::uint32_t depth, std::uint32_t wake_bits = 0) {
  return {.depth = depth, .payload = kPayload, .is_queue = true, .wake_bits = wake_bits};
}

class DdsGateway : public testing::Test {
 protected:
  void SetUp() override {
    auto participant = dds::Participant::create(on_loopback("test"));
    ASSERT_TRUE(participant.ok()) << to_text(participant.problems());
    participant_ = *participant;
    auto gateway = dds::Gateway::create(participant_, wake_word_);
    ASSERT_TRUE(gateway.ok());
    gateway_ = std::move(*gateway);
  }

  void TearDown() override {
    gateway_.reset();
    Memory::free_all();
  }

  /// Writes a sample as a module does. Then wakes the readers of the link as the executor does at the end of
  /// a cycle.
  void write(channel::LinkWriter& writer, const std::vector<std::byte>& bytes,
             std::int64_t stamp = to_ns(os::now())) {
    std::memcpy(writer.link().payload(writer.buffer()), bytes.data(), bytes.size());
    writer.publish(static_cast<std::uint32_t>(bytes.size()), stamp);
    wake_word_.note(writer.link().block().wake_bits);
    if (const std::uint32_t bits = wake_word_.take_pending(); bits != 0) {
      wake_word_.rings.fetch_add(1);
      os::futex_wake(wake_word_.rings, bits);
    }
  }
  /// Writes sample 0 repeatedly until the peer prints it, because the peer's reader may match this writer
  /// late.
  void write_until_received(channel::LinkWriter& writer, Peer& tap) {
    ASSERT_TRUE(soon([&] {
      write(writer, bytes_of(0));
      const auto line = tap.line(20ms);
      return line && *line == "sample 0";
    }));
  }
  wire::FlowHealth health(dds::Gateway::FlowId flow) const { return gateway_->health(flow); }

  channel::WakeWord wake_word_{};
  std::shared_ptr<dds::Participant> participant_;
  std::unique_ptr<dds::Gateway> gateway_;
};

constexpr std::uint32_t kWake = channel::kGatewayBit;
const dds::Quality kReliable{.reliable = true, .depth = 64, .deadline = {}, .lifespan = {}};

TEST_F(DdsGateway, SendsCompleteSamplesInOrder) {
  const Memory memory{queue(64, kWake)};
  const auto flow_id = gateway_->add_outgoing(flow("out", kReliable), memory.link());
  ASSERT_TRUE(flow_id.ok());
  Peer tap{{"tap", "out", "reliable", "64"}};
  channel::LinkWriter writer{memory.link()};
  write_until_received(writer, tap);
  // Both queues have 64 places, so at most 64 samples may be on their way.
  for (std::uint64_t begin = 1; begin <= 500; begin += 50) {
    for (std::uint64_t number = begin; number < begin + 50; ++number)
      write(writer, bytes_of(number, 0, static_cast<std::uint32_t>(number * 37 % 5000)));
    std::optional<std::string> line = tap.line();
    while (begin == 1 && line == "sample 0") line = tap.line();
    for (std::uint64_t number = begin; number < begin + 50; ++number) {
      ASSERT_EQ(line, "sample " + std::to_string(number));
      if (number + 1 < begin + 50) line = tap.line();
    }
  }
  EXPECT_EQ(health(*flow_id).failures, 0U);
  EXPECT_EQ(memory.link().block().overwritten.load(), 0U);
}

TEST_F(DdsGateway, ReceivesCompleteSamplesInOrderWithTheirTimeStamps) {
  const Memory memory{queue(256)};
  const Memory latest{{.depth = 1, .payload = kPayload}};
  const auto flow_id = gateway_->add_incoming(flow("in", kReliable), {memory.link(), latest.link()});
  ASSERT_TRUE(flow_id.ok());
  Peer feed{{"feed", "in", "reliable", "64"}};
  ASSERT_TRUE(feed.prints("ready"));
  ASSERT_TRUE(soon([&] { return health(*flow_id).matched == 1; }));
  std::this_thread::sleep_for(300ms);  // time for the peer's writer to match this reader
  const std::int64_t begin = to_ns(os::now());
  feed.write("200");
  ASSERT_TRUE(soon([&] { return health(*flow_id).samples == 200; }));
  const std::int64_t end = to_ns(os::now());
  channel::LinkReader reader{memory.link()};
  std::int64_t last = begin - 1'000'000;  // tolerance of 1 ms: the system may correct the wall clock
  for (std::uint64_t number = 1; number <= 200; ++number) {
    ASSERT_TRUE(reader.take());
    const std::byte* bytes = reader.link().payload(reader.buffer());
    EXPECT_TRUE(is_whole(bytes, reader.info().size));
    EXPECT_EQ(number_in(bytes), number);
    EXPECT_GE(reader.info().stamp_ns, last);
    EXPECT_LE(reader.info().stamp_ns, end);
    last = reader.info().stamp_ns - 100'000;  // tolerance of 100 us for the conversion between two clocks
  }
  channel::LinkReader newest{latest.link()};
  ASSERT_TRUE(newest.take());
  EXPECT_EQ(number_in(newest.link().payload(newest.buffer())), 200U);
  EXPECT_EQ(health(*flow_id).lost, 0U);
}

TEST_F(DdsGateway, KeepsTheTimeStampOfAModuleUnlessTheTimeIsImplausible) {
  const Memory out{queue(4, kWake)};
  const Memory in{queue(4)};
  const auto going = gateway_->add_outgoing(flow("stamp", kReliable), out.link());
  const auto coming = gateway_->add_incoming(flow("stamp", kReliable), {in.link()});
  ASSERT_TRUE(going.ok() && coming.ok());
  ASSERT_TRUE(soon([&] { return health(*going).matched == 1 && health(*coming).matched == 1; }));
  channel::LinkWriter writer{out.link()};
  const std::int64_t now = to_ns(os::now());
  write(writer, bytes_of(1), now - 7'000'000'000);
  write(writer, bytes_of(2), now - 100'000'000'000);       // 100 s old, as from a module whose clock is wrong
  write(writer, bytes_of(3), -4'000'000'000'000'000'001);  // before 1970: Fast DDS would never return
  ASSERT_TRUE(soon([&] { return health(*coming).samples == 3; }));
  channel::LinkReader reader{in.link()};
  ASSERT_TRUE(reader.take());
  EXPECT_NEAR(static_cast<double>(reader.info().stamp_ns), static_cast<double>(now - 7'000'000'000), 5e6);
  ASSERT_TRUE(reader.take());
  EXPECT_GE(reader.info().stamp_ns, now) << "the gateway uses the time of arrival instead";
}

/// What the node stores in a link whose samples come from a device whose clock is `ahead` of this one.
std::int64_t clock_ahead_by(Nanoseconds ahead) { return os::wall_ns() - to_ns(os::now()) + ahead.count(); }

TEST_F(DdsGateway, KnowsTheAgeOfASampleFromADeviceWhoseClockIsAhead) {
  const Memory out{queue(4, kWake)};
  const Memory in{queue(4)};
  const auto going = gateway_->add_outgoing(flow("ahead", kReliable), out.link());
  const auto coming = gateway_->add_incoming(flow("ahead", kReliable), {in.link()});
  ASSERT_TRUE(going.ok() && coming.ok());
  ASSERT_TRUE(soon([&] { return health(*going).matched == 1 && health(*coming).matched == 1; }));
  in.link().block().sender_clock_ns = clock_ahead_by(500ms);
  channel::LinkWriter writer{out.link()};
  const std::int64_t now = to_ns(os::now());
  write(writer, bytes_of(1), now - 310'000'000 + 500'000'000);  // 310 ms old
  write(writer, bytes_of(2), now + 900'000'000);                // from the future, even by the sender's clock
  ASSERT_TRUE(soon([&] { return health(*coming).samples == 2; }));
  channel::LinkReader reader{in.link()};
  ASSERT_TRUE(reader.take());
  EXPECT_NEAR(static_cast<double>(reader.info().stamp_ns), static_cast<double>(now - 310'000'000), 5e6);
  ASSERT_TRUE(reader.take());
  EXPECT_GE(reader.info().stamp_ns, now);
  EXPECT_LE(reader.info().stamp_ns, to_ns(os::now()));
  EXPECT_EQ(health(*coming).untimed, 1U);
}

TEST_F(DdsGateway, WakesUpAsSoonAsASampleIsWritten) {
  const Memory memory{queue(64, kWake)};
  const auto flow_id = gateway_->add_outgoing(flow("out"), memory.link());
  ASSERT_TRUE(flow_id.ok());
  channel::LinkWriter writer{memory.link()};
  std::vector<double> waited;
  for (std::uint64_t number = 1; number <= 40; ++number) {
    ASSERT_TRUE(soon([&] { return wake_word_.gateway_sleeps.load() == 1; }));
    std::this_thread::sleep_for(3ms);
    const auto begin = Clock::now();
    write(writer, bytes_of(number));
    ASSERT_TRUE(soon([&] { return health(*flow_id).samples == number; }));
    waited.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
  }
  std::nth_element(waited.begin(), waited.begin() + 20, waited.end());
  EXPECT_LT(waited[20], 0.02) << "a gateway that is not woken checks only every 100 ms";
}

TEST_F(DdsGateway, WakesAThreadThatWaitsForASample) {
  const Memory memory{queue(64, channel::kSporadicBit)};
  const auto flow_id = gateway_->add_incoming(flow("in", kReliable), {memory.link()});
  ASSERT_TRUE(flow_id.ok());
  std::atomic<int> woken{0};
  std::atomic<bool> ending{false};
  std::thread sporadic{[&] {
    channel::LinkReader reader{memory.link()};
    while (!ending) {
      const std::uint32_t rings = wake_word_.rings.load();
      if (reader.take())
        ++woken;
      else
        os::futex_wait(wake_word_.rings, rings, channel::kSporadicBit, os::now() + long_enough());
    }
  }};
  auto feed = dds::Feed::create(participant_, flow("in", kReliable));
  ASSERT_TRUE(feed.ok());
  ASSERT_TRUE(soon([&] { return (*feed)->health().matched == 1; }));
  for (std::uint64_t number = 1; number <= 100; ++number) {
    const auto bytes = bytes_of(number);
    ASSERT_TRUE((*feed)->write(bytes.data(), bytes.size()));
    std::this_thread::sleep_for(500us);
  }
  EXPECT_TRUE(soon([&] { return woken == 100; })) << woken;
  ending = true;
  wake_word_.rings.fetch_add(1);
  os::futex_wake(wake_word_.rings, ~0U);
  sporadic.join();
}

TEST_F(DdsGateway, DropsAndCountsInvalidSamples) {
  const Memory memory{queue(64)};
  const auto flow_id = gateway_->add_incoming(flow("in", kReliable), {memory.link()});
  ASSERT_TRUE(flow_id.ok());
  std::string good;
  for (const std::byte each : bytes_of(5, 5, 40)) {
    std::array<char, 3> digits{};
    std::snprintf(digits.data(), digits.size(), "%02x", static_cast<unsigned>(each));
    good += digits.data();
  }
  good.resize(48);  // the sample claims 40 bytes of data but has none, so it is too short
  Peer forger{{"forge", "in", "test::Sample", "plain", "500", good}};
  ASSERT_TRUE(forger.prints("forged"));
  const wire::FlowHealth after = health(*flow_id);
  EXPECT_EQ(after.refused + after.samples, 500U);
  EXPECT_GT(after.refused, 300U);
  EXPECT_EQ(after.lost, 0U) << "rejected samples do not count as lost";
  EXPECT_EQ(memory.link().block().written.load(), after.samples);
  Peer honest{{"feed", "in", "reliable", "64"}};
  EXPECT_TRUE(soon([&] {
    honest.write("1");
    std::this_thread::sleep_for(50ms);
    return health(*flow_id).samples > after.samples;
  }));
}

TEST_F(DdsGateway, CountsSamplesThatDdsRejects) {
  const Memory memory{{.depth = 4, .payload = 2 * kPayload, .is_queue = true, .wake_bits = kWake}};
  const auto flow_id = gateway_->add_outgoing(flow("out", kReliable), memory.link());
  ASSERT_TRUE(flow_id.ok());
  channel::LinkWriter writer{memory.link()};
  write(writer, bytes_of(1, 0, 2 * kMostData));
  write(writer, bytes_of(2));
  EXPECT_TRUE(soon([&] { return health(*flow_id).failures == 1 && health(*flow_id).samples == 1; }))
      << health(*flow_id).failures << " " << health(*flow_id).samples;
}

TEST_F(DdsGateway, RejectsALinkThatIsTooSmallForTheType) {
  const Memory memory{{.depth = 4, .payload = 100}};
  const auto in = gateway_->add_incoming(flow("in"), {memory.link()});
  ASSERT_FALSE(in.ok());
  EXPECT_THAT(to_text(in.problems()), testing::HasSubstr("test::Sample"));
  EXPECT_FALSE(gateway_->add_outgoing(flow("out"), memory.link()).ok());
}

TEST_F(DdsGateway, WritesNothingToADisabledLink) {
  const Memory wanted{queue(8)};
  const Memory unwanted{{.depth = 8, .payload = kPayload, .enabled = false}};
  const auto flow_id = gateway_->add_incoming(flow("in", kReliable), {wanted.link(), unwanted.link()});
  auto feed = dds::Feed::create(participant_, flow("in", kReliable));
  ASSERT_TRUE(flow_id.ok() && feed.ok());
  ASSERT_TRUE(soon([&] { return (*feed)->health().matched == 1; }));
  const auto bytes = bytes_of(1);
  (*feed)->write(bytes.data(), bytes.size());
  ASSERT_TRUE(soon([&] { return health(*flow_id).samples == 1; }));
  EXPECT_EQ(wanted.link().block().written.load(), 1U);
  EXPECT_EQ(unwanted.link().block().written.load(), 0U);
}

TEST_F(DdsGateway, SendsToOtherReadersWhileOneReaderHangs) {
  const Memory to_stuck{queue(64, kWake)};
  const Memory to_live{queue(64, kWake)};
  const auto stuck_id = gateway_->add_outgoing(flow("stuck", kReliable), to_stuck.link());
  const auto live_id = gateway_->add_outgoing(flow("live", kReliable), to_live.link());
  ASSERT_TRUE(stuck_id.ok() && live_id.ok());
  Peer stuck{{"tap", "stuck", "reliable", "64"}};
  Peer live{{"tap", "live", "reliable", "64"}};
  ASSERT_TRUE(soon([&] { return health(*stuck_id).matched == 1 && health(*live_id).matched == 1; }));
  stuck.signal(SIGSTOP);
  channel::LinkWriter to_one{to_stuck.link()};
  channel::LinkWriter to_other{to_live.link()};
  const auto begin = Clock::now();
  for (std::uint64_t number = 1; number <= 1000; ++number) {
    write(to_one, bytes_of(number, 0, 1000));
    write(to_other, bytes_of(number));
    std::this_thread::sleep_for(1ms);
  }
  ASSERT_TRUE(live.prints("sample 1000", 5s));
  EXPECT_LT(Clock::now() - begin, 10s);
  EXPECT_EQ(to_live.link().block().overwritten.load() + to_stuck.link().block().overwritten.load(), 0U)
      << "the gateway was never more than 64 samples behind";
  EXPECT_EQ(health(*stuck_id).failures, 0U);
}

TEST_F(DdsGateway, AddsAndRemovesFlowsWithoutDisturbingOtherFlows) {
  const Memory memory{queue(256, kWake)};
  const auto flow_id = gateway_->add_outgoing(flow("steady", kReliable), memory.link());
  ASSERT_TRUE(flow_id.ok());
  Peer tap{{"tap", "steady", "reliable", "64"}};
  channel::LinkWriter writer{memory.link()};
  write_until_received(writer, tap);
  std::atomic<bool> ending{false};
  std::thread changing{[&] {
    const Memory in{queue(8, channel::kSporadicBit)};
    const Memory out{queue(8, kWake)};
    while (!ending) {
      const auto going = gateway_->add_outgoing(flow("passing", kReliable), out.link());
      const auto coming = gateway_->add_incoming(flow("passing", kReliable), {in.link()});
      channel::LinkWriter passing{out.link()};
      for (std::uint64_t number = 1; number <= 5; ++number) {
        std::memcpy(out.link().payload(passing.buffer()), bytes_of(number).data(), 24);
        passing.publish(24, to_ns(os::now()));
        std::this_thread::sleep_for(1ms);
      }
      gateway_->remove(*going);
      gateway_->remove(*coming);
      EXPECT_EQ(health(*going).samples + health(*coming).matched, 0U) << "the flow is removed";
    }
  }};
  for (std::uint64_t number = 1; number <= 3000; ++number) {
    write(writer, bytes_of(number));
    std::this_thread::sleep_for(500us);
  }
  ending = true;
  changing.join();
  ASSERT_TRUE(tap.prints("sample 1"));
  for (std::uint64_t number = 2; number <= 3000; ++number)
    ASSERT_EQ(tap.line(), "sample " + std::to_string(number));
}

TEST_F(DdsGateway, LetsSeveralThreadsAddAndRemoveFlowsOfOneTopic) {
  std::atomic<bool> ending{false};
  std::vector<std::thread> writing;
  for (int i = 0; i < 4; ++i) {
    writing.emplace_back([&] {
      const Memory out{queue(8, kWake)};
      while (!ending) {
        const auto going = gateway_->add_outgoing(flow("passing", kReliable), out.link());
        channel::LinkWriter writer{out.link()};
        for (std::uint64_t number = 1; number <= 60; ++number) {
          write(writer, bytes_of(number));
          std::this_thread::sleep_for(20us);
        }
        gateway_->remove(*going);
      }
    });
  }
  const Memory in{queue(8, channel::kSporadicBit)};
  for (int i = 0; i < 300; ++i) {
    const auto coming = gateway_->add_incoming(flow("passing", kReliable), {in.link()});
    ASSERT_TRUE(coming.ok());
    std::this_thread::sleep_for(4ms);
    gateway_->remove(*coming);
  }
  ending = true;
  for (std::thread& one : writing) one.join();
}

TEST_F(DdsGateway, ReportsTheQosPolicyThatPreventsAMatch) {
  const Memory out{queue(8, kWake)};
  const auto going = gateway_->add_outgoing(flow("quality"), out.link());
  ASSERT_TRUE(going.ok());
  Peer tap{{"tap", "quality", "reliable", "8"}};
  ASSERT_TRUE(tap.prints("ready"));
  EXPECT_TRUE(soon([&] { return health(*going).incompatible == "reliability"; }));
  EXPECT_EQ(health(*going).matched, 0U);
  EXPECT_TRUE(soon([&] {
    tap.write("health");
    return tap.line() == "matched 0 samples 0 lost 0 refused 0 incompatible reliability";
  }));

  const Memory in{queue(8)};
  const auto coming = gateway_->add_incoming(
      flow("deadline", {.reliable = false, .depth = 1, .deadline = 10ms, .lifespan = {}}), {in.link()});
  ASSERT_TRUE(coming.ok());
  Peer feed{{"feed", "deadline", "best-effort", "1"}};
  EXPECT_TRUE(soon([&] { return health(*coming).incompatible == "deadline"; }));
}

TEST_F(DdsGateway, CountsLostSamples) {
  const Memory memory{queue(64, kWake)};
  const auto flow_id = gateway_->add_outgoing(flow("lossy"), memory.link());
  ASSERT_TRUE(flow_id.ok());
  Peer tap{{"tap", "lossy", "best-effort", "1"}};
  ASSERT_TRUE(tap.prints("ready"));
  channel::LinkWriter writer{memory.link()};
  std::uint64_t number = 0;
  std::optional<std::string> first;
  ASSERT_TRUE(soon([&] {
    write(writer, bytes_of(++number));
    return (first = tap.line(20ms)).has_value();
  }));
  tap.signal(SIGSTOP);  // the stopped peer loses samples that do not fit into its socket (4 MB)
  for (int i = 0; i < 300; ++i) {
    write(writer, bytes_of(++number, 0, 50000));
    std::this_thread::sleep_for(1ms);
  }
  tap.signal(SIGCONT);
  ASSERT_TRUE(soon([&] {
    write(writer, bytes_of(++number));
    return tap.prints("sample " + std::to_string(number), 100ms);
  }));
  tap.write("health");
  std::istringstream words{*tap.line()};
  std::string word;
  std::uint64_t matched = 0;
  std::uint64_t samples = 0;
  std::uint64_t lost = 0;
  words >> word >> matched >> word >> samples >> word >> lost;
  EXPECT_GT(lost, 0U);
  EXPECT_EQ(samples + lost, number - std::stoul(first->substr(first->find(' '))) + 1);
}

TEST_F(DdsGateway, DropsSamplesOlderThanTheirLifespan) {
  const dds::Quality brief{.reliable = true, .depth = 8, .deadline = {}, .lifespan = 200ms};
  const Memory out{queue(8, kWake)};
  const Memory in{queue(8)};
  const auto going = gateway_->add_outgoing(flow("brief", brief), out.link());
  const auto coming = gateway_->add_incoming(flow("brief", brief), {in.link()});
  ASSERT_TRUE(going.ok() && coming.ok());
  ASSERT_TRUE(soon([&] { return health(*going).matched == 1 && health(*coming).matched == 1; }));
  channel::LinkWriter writer{out.link()};
  write(writer, bytes_of(1), to_ns(os::now()) - 1'000'000'000);
  write(writer, bytes_of(2));
  ASSERT_TRUE(soon([&] { return in.link().block().written.load() > 0; }));
  channel::LinkReader reader{in.link()};
  ASSERT_TRUE(reader.take());
  EXPECT_EQ(number_in(reader.link().payload(reader.buffer())), 2U);
}

TEST_F(DdsGateway, ComparesTheLifespanWithTheAgeAccordingToTheSendersClock) {
  for (const bool is_ahead : {true, false}) {
    const std::string topic = is_ahead ? "brief ahead" : "brief behind";
    const dds::Quality brief{.reliable = true, .depth = 8, .deadline = {}, .lifespan = 200ms};
    const Memory out{queue(8, kWake)};
    const Memory in{queue(8)};
    const auto going = gateway_->add_outgoing(flow(topic, kReliable), out.link());
    const auto coming = gateway_->add_incoming(flow(topic, brief), {in.link()});
    ASSERT_TRUE(going.ok() && coming.ok());
    ASSERT_TRUE(soon([&] { return health(*going).matched == 1 && health(*coming).matched == 1; }));
    const Nanoseconds ahead = is_ahead ? 500ms : -500ms;
    in.link().block().sender_clock_ns = clock_ahead_by(ahead);
    channel::LinkWriter writer{out.link()};
    write(writer, bytes_of(1), to_ns(os::now()) - 310'000'000 + ahead.count());
    write(writer, bytes_of(2), to_ns(os::now()) + ahead.count());
    ASSERT_TRUE(soon([&] { return health(*coming).samples == 2; }));
    channel::LinkReader reader{in.link()};
    ASSERT_TRUE(soon([&] { return reader.take(); })) << topic;
    EXPECT_EQ(number_in(reader.link().payload(reader.buffer())), 2U) << topic;
    EXPECT_EQ(health(*coming).lost, 1U) << topic;
    gateway_->remove(*going);
    gateway_->remove(*coming);
  }
}

TEST_F(DdsGateway, CarriesSamplesOfTheMaximumSize) {
  const Memory out{queue(4, kWake)};
  const Memory in{queue(4)};
  const auto going = gateway_->add_outgoing(flow("large", kReliable), out.link());
  const auto coming = gateway_->add_incoming(flow("large", kReliable), {in.link()});
  ASSERT_TRUE(going.ok() && coming.ok());
  ASSERT_TRUE(soon([&] { return health(*going).matched == 1 && health(*coming).matched == 1; }));
  channel::LinkWriter writer{out.link()};
  for (const std::uint32_t data : {0U, 1U, 2U, 3U, 65507U, static_cast<std::uint32_t>(kMostData)})
    write(writer, bytes_of(data, 0, data)), std::this_thread::sleep_for(20ms);
  channel::LinkReader reader{in.link()};
  // The link has room for only 4 of the 6 samples, so the gateway may overwrite the oldest samples.
  ASSERT_TRUE(soon([&] { return health(*coming).samples == 6; })) << health(*coming).samples;
  EXPECT_EQ(health(*coming).refused, 0U);
  std::uint64_t last = 0;
  while (reader.take()) {
    last = number_in(reader.link().payload(reader.buffer()));
    EXPECT_TRUE(is_whole(reader.link().payload(reader.buffer()), reader.info().size)) << last;
  }
  EXPECT_EQ(last, kMostData);
}

// ---- Packets that a participant forges in the name of its own writer, which has matched the reader

std::string hex(std::uint64_t value, int bytes) {
  std::ostringstream text;
  for (int i = 0; i < bytes; ++i)
    text << std::hex << std::setw(2) << std::setfill('0') << (value >> 8 * i & 0xff);
  return text.str();
}
std::string number(std::uint64_t value) { return hex(value >> 32, 4) + hex(value, 4); }
std::string hex(const std::vector<std::byte>& bytes) {
  std::string text;
  for (const std::byte byte : bytes) text += hex(std::to_integer<std::uint64_t>(byte), 1);
  return text;
}

/// Returns a HEARTBEAT. `count` must be larger than in all HEARTBEATs that the writer itself sends.
std::string heartbeat(std::uint64_t first, std::uint32_t count) {
  return "07 03 - " + number(first) + number(first) + hex(count, 4) + " 0";
}
/// Returns a GAP that skips the samples from `start` to `end` - 1, and those in `list`. The numbers in `list`
/// are less than `end` + 32.
std::string gap(std::uint64_t start, std::uint64_t end, const std::vector<std::uint64_t>& list = {}) {
  std::uint32_t bits = 0;
  for (const std::uint64_t each : list) bits |= 0x80000000U >> (each - end);
  return "08 01 - " + number(start) + number(end) + hex(32, 4) + hex(bits, 4) + " 0";
}
std::string data(std::uint64_t sequence, const std::vector<std::byte>& bytes) {
  return "15 05 00001000 " + number(sequence) + hex(bytes) + " 0";
}
/// Returns a DATA_FRAG of sample 1 with `count` fragments, whose bytes are 0.
std::string fragments(std::uint32_t first, std::uint32_t count, std::uint32_t size, std::uint32_t sample) {
  const std::uint32_t end = std::min((first - 1 + count) * size, sample);
  return "16 01 00001c00 " + number(1) + hex(first, 4) + hex(count, 2) + hex(size, 2) + hex(sample, 4) + " " +
         std::to_string(end - (first - 1) * size);
}

/// Returns fragment `which` of two fragments of this sample.
std::string half(std::uint64_t sequence, std::uint32_t which) {
  return "16 01 00001c00 " + number(sequence) + hex(which, 4) + hex(1, 2) + hex(100, 2) + hex(200, 4) +
         " 100";
}

std::size_t resident_bytes() {
  std::ifstream file{"/proc/self/statm"};
  std::size_t all = 0;
  std::size_t resident = 0;
  file >> all >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

// Fast DDS would send fragment 1 to this reader in an endless loop: 0xfffffff1 + 16 overflows to it.
TEST_F(DdsGateway, IgnoresRequestsWithOverflowingFragmentNumbers) {
  const Memory memory{queue(64, kWake)};
  const auto id = gateway_->add_outgoing(flow("doubted", kReliable), memory.link());
  ASSERT_TRUE(id.ok());
  Peer doubting{{"doubt", "doubted"}};
  Peer tap{{"tap", "doubted", "reliable", "64"}};
  ASSERT_TRUE(soon([&] { return health(*id).matched == 2; }));
  channel::LinkWriter writer{memory.link()};
  write(writer, bytes_of(1, 0, 50000));
  ASSERT_TRUE(tap.prints("sample 1"));
  const std::uint64_t before = participant_->refused();
  doubting.write("12 01 " + number(1) + hex(0xfffffff1, 4) + hex(32, 4) + "00800000" + hex(1000, 4));
  ASSERT_TRUE(doubting.prints("sent"));
  EXPECT_TRUE(soon([&] { return participant_->refused() > before; }));
  write(writer, bytes_of(2, 0, 50000));
  EXPECT_TRUE(tap.prints("sample 2"));
}

class DeceivedGateway : public DdsGateway {
 protected:
  /// Makes a reader and a peer whose writer matches it.
  void deceive(const std::string& reliability) {
    const std::string topic = "deceived";
    dds::Quality quality = kReliable;
    quality.reliable = reliability == "reliable";
    const auto id = gateway_->add_incoming(flow(topic, quality), {memory_.link()});
    ASSERT_TRUE(id.ok());
    deceived_ = *id;
    peer_.emplace(std::vector<std::string>{"deceive", topic, reliability});
    ASSERT_TRUE(soon([&] { return health(deceived_).matched == 1; }));
  }
  void send(const std::string& packet) {
    peer_->write(packet);
    ASSERT_TRUE(peer_->prints("sent"));
  }
  /// Expects that the gateway receives samples of another writer, and so has handled all earlier packets.
  void expect_that_the_gateway_works() {
    const std::string topic = "honest-" + std::to_string(++honest_);
    const auto id = gateway_->add_incoming(flow(topic, kReliable), {memory_.link()});
    ASSERT_TRUE(id.ok());
    Peer feed{{"feed", topic, "reliable", "64"}};
    EXPECT_TRUE(soon([&] {
      feed.write("1");
      return health(*id).samples > 0;
    }));
  }

  const Memory memory_{queue(64)};
  dds::Gateway::FlowId deceived_{};
  std::optional<Peer> peer_;
  int honest_ = 0;
};

TEST_F(DeceivedGateway, SkipsABillionSamplesThatAHeartbeatReportsAsLost) {
  deceive("reliable");
  send(heartbeat(1 << 30, 1000));
  send(data(1 << 30, bytes_of(7)));
  EXPECT_TRUE(soon([&] { return health(deceived_).samples == 1; }));
  send(heartbeat(std::uint64_t{1} << 62, 1001));  // the largest number that the packet filter accepts
  expect_that_the_gateway_works();
}

TEST_F(DeceivedGateway, SkipsAGapOfABillionSamples) {
  deceive("reliable");
  send(gap(1, 1 << 30));
  send(data(1 << 30, bytes_of(7)));
  EXPECT_TRUE(soon([&] { return health(deceived_).samples == 1; }));
  send(gap(1, std::uint64_t{1} << 62));
  expect_that_the_gateway_works();
}

TEST_F(DeceivedGateway, StoresOnlyTheBeginningOfAGapAfterAMissingSample) {
  deceive("reliable");
  const std::size_t before = resident_bytes();
  for (std::uint64_t i = 0; i < 64; ++i) send(gap(2 + (i << 18), 2 + ((i + 1) << 18)));
  send(gap(2, std::uint64_t{1} << 62));
  expect_that_the_gateway_works();
  EXPECT_LT(resident_bytes(), before + 100'000'000);
}

// Fast DDS stores the first fragments of a sample without a key like a complete one.
TEST_F(DeceivedGateway, ForgetsTheFragmentsOfASampleThatAGapSkips) {
  deceive("reliable");
  send(half(2, 1));
  send(gap(2, 3));
  send(half(3, 1));  // in the memory of sample 2
  send(data(3, bytes_of(7)));
  send(data(1, bytes_of(8)));
  EXPECT_TRUE(soon([&] { return health(deceived_).samples == 2; })) << health(deceived_).samples;
  expect_that_the_gateway_works();
  EXPECT_EQ(health(deceived_).refused, 0U);
}

// Then an assertion of Fast DDS 3 would end the process.
TEST_F(DeceivedGateway, GivesUpAnIncompleteSampleAfterALaterOne) {
  deceive("best_effort");
  send(half(1, 1));
  send(data(2, bytes_of(7)));
  send(half(3, 1));
  send(data(4, bytes_of(8)));
  EXPECT_TRUE(soon([&] { return health(deceived_).samples == 2; })) << health(deceived_).samples;
}

class DeceivedFragments : public DeceivedGateway, public testing::WithParamInterface<const char*> {
 protected:
  void SetUp() override {
    DeceivedGateway::SetUp();
    deceive(GetParam());
  }
  void expect_samples(std::uint64_t count) {
    expect_that_the_gateway_works();
    const wire::FlowHealth found = health(deceived_);
    EXPECT_EQ(found.samples + found.refused, count);
  }
};
INSTANTIATE_TEST_SUITE_P(Reader, DeceivedFragments, testing::Values("reliable", "best_effort"),
                         [](const auto& parameter) { return std::string{parameter.param}; });

TEST_P(DeceivedFragments, AreNotMixedWithFragmentsThatContradictThem) {
  send(fragments(1, 1, 4000, 8000));
  send(fragments(2, 1, 4, 8));  // Fast DDS would copy 4000 bytes from this packet
  send(fragments(2, 1, 4000, 7000));
  expect_samples(0);
  send(fragments(1, 1, 4000, 8000));
  send(fragments(2, 1, 4000, 8000));
  expect_samples(1);
}

TEST_P(DeceivedFragments, MayArriveInOnePacket) {
  send(fragments(1, 2, 4000, 8000));
  send(data(2, bytes_of(7)));
  expect_samples(2);
}

TEST_P(DeceivedFragments, GiveWayToTheWholeSample) {
  send(fragments(2, 1, 4000, 8000));
  send(data(1, bytes_of(7)));
  send(data(2, bytes_of(8)));
  expect_samples(2);
}

// In each missing fragment, Fast DDS stores the number of the next missing fragment, which has 4 bytes.
TEST_P(DeceivedFragments, AreIgnoredIfTheyAreTooShortForTheNumberThatFastDdsStores) {
  send(fragments(1, 30, 3, 90));
  expect_samples(0);
  send(fragments(1, 20, 5, 100));
  expect_samples(1);
}

// The last fragment of this sample, which has the maximum size of 65563 bytes, has only one byte.
TEST_P(DeceivedFragments, AreIgnoredIfTheNumberThatFastDdsStoresWouldExceedTheMemoryOfTheReader) {
  constexpr std::uint32_t kMost = kMostData + 27;
  send(fragments(1, 13, 4683, kMost));
  send(fragments(14, 2, 4683, kMost));
  expect_samples(0);
}

std::vector<std::byte> bytes_of(const FaultEvent& event) {
  FaultEventPubSubType type;
  dds::rtps::SerializedPayload_t payload{dds::max_size_of(type)};
  EXPECT_TRUE(dds::encode_sample(type, &event, payload));
  const auto* begin = reinterpret_cast<const std::byte*>(payload.data);
  return {begin, begin + payload.length};
}

// The key hash in a fragment makes Fast DDS store the unfinished sample under this key. When the sample is
// lost, Fast DDS reuses its memory, but would still find it under the key.
TEST_F(DeceivedGateway, ForgetsTheKeyOfALostSampleOfWhichItHasFragments) {
  std::atomic<std::uint64_t> received{0};
  auto reader = dds::Reader<FaultEvent>::create(
      participant_, {.sample = [&received](const FaultEvent&, wire::WriterId) { ++received; }});
  ASSERT_TRUE(reader.ok());
  peer_.emplace(std::vector<std::string>{"deceive", "takt/fault", "reliable", "takt::FaultEvent"});
  ASSERT_TRUE(soon([&] { return reader->matched() == 1; }));
  const std::string key_hash = "70001000" + hex(1, 8) + hex(1, 8) + "01000000";
  send("16 03 00001c00 " + number(1) + hex(1, 4) + hex(1, 2) + hex(100, 2) + hex(200, 4) + key_hash + " 100");
  send(heartbeat(2, 1000));
  FaultEvent event;
  event.path("cell/robot");
  for (std::uint64_t i = 2; i < 5; ++i) {
    send(data(i, bytes_of(event)));
    EXPECT_TRUE(soon([&] { return received + reader->refused() == i - 1; })) << i;
  }
  // The next sample comes first in part, without a key hash, and then as a whole.
  send(half(5, 1));
  send(data(5, bytes_of(event)));
  EXPECT_TRUE(soon([&] { return received + reader->refused() == 4; }));
}

/// A reader that keeps 64 samples of each key, and a peer whose writer matches it.
class DeceivedReader : public DeceivedGateway {
 protected:
  void SetUp() override {
    DeceivedGateway::SetUp();
    auto reader = dds::Reader<FaultEvent>::create(
        participant_, {.sample = [this](const FaultEvent&, wire::WriterId) { ++received_; }});
    ASSERT_TRUE(reader.ok());
    reader_.emplace(std::move(*reader));
    peer_.emplace(std::vector<std::string>{"deceive", "takt/fault", "reliable", "takt::FaultEvent"});
    ASSERT_TRUE(soon([&] { return reader_->matched() == 1; }));
  }
  /// Returns the number of samples that the reader has got, valid or not.
  [[nodiscard]] std::uint64_t samples() const { return received_ + reader_->refused(); }
  /// Lets the reader wait for a missing sample, fills its history, and then calls `send_older` to send it
  /// samples of the same key, whose time is before 100 s.
  template <class SendOlder>
  void expect_that_older_samples_are_freed(SendOlder&& send_older) {
    FaultEvent event;
    event.path("cell/robot");
    event.cause(std::string(500, 'x'));
    constexpr std::size_t kOlder = 500;
    std::size_t used = 0;
    std::uint64_t sequence = 1;
    for (std::uint32_t round = 1; round <= 2; ++round) {
      ++sequence;  // the sample before is missing, so that the following ones wait
      for (int i = 0; i < 64; ++i) send(data(sequence++, bytes_of(event)) + " 100");
      for (std::size_t i = 0; i < kOlder; ++i) send_older(sequence++, bytes_of(event));
      send(heartbeat(sequence, 1000 + round));
      ASSERT_TRUE(soon([&] { return samples() == 64 * round; })) << samples();
      const std::size_t now = ::mallinfo2().uordblks;
      EXPECT_TRUE(round == 1 || now < used + kOlder * 500) << used << " " << now;
      used = now;
    }
  }

  std::atomic<std::uint64_t> received_{0};
  std::optional<dds::Reader<FaultEvent>> reader_;
};

TEST_F(DeceivedReader, FreesSamplesThatAreOlderThanAllWaitingSamplesOfTheirKey) {
  expect_that_older_samples_are_freed([this](std::uint64_t sequence, const std::vector<std::byte>& bytes) {
    send(data(sequence, bytes) + " 50");
  });
}

TEST_F(DeceivedReader, FreesFragmentedSamplesThatAreOlderThanAllWaitingSamplesOfTheirKey) {
  expect_that_older_samples_are_freed([this](std::uint64_t sequence, const std::vector<std::byte>& bytes) {
    constexpr std::ptrdiff_t kSize = 400;
    const std::string sizes = hex(1, 2) + hex(kSize, 2) + hex(bytes.size(), 4);
    const std::string head = "16 01 00001c00 " + number(sequence);
    send(head + hex(1, 4) + sizes + hex({bytes.begin(), bytes.begin() + kSize}) + " 0 50");
    send(head + hex(2, 4) + sizes + hex({bytes.begin() + kSize, bytes.end()}) + " 0 50");
  });
}

// Fast DDS compares samples of one writer by their numbers, but samples of two writers by their times.
TEST_F(DeceivedReader, FindsWaitingSamplesAfterAClockWasSetBack) {
  const auto of = [](const char* path) {
    FaultEvent event;
    event.path(path);
    return bytes_of(event);
  };
  Peer other{{"deceive", "takt/fault", "reliable", "takt::FaultEvent"}};
  const auto send_other = [&](const std::string& packet) {
    other.write(packet);
    ASSERT_TRUE(other.prints("sent"));
  };
  ASSERT_TRUE(soon([&] { return reader_->matched() == 2; }));
  send_other(data(2, of("cell/station")) + " 50");
  send_other(data(3, of("cell/station")) + " 60");
  send_other(data(4, of("cell/station")) + " 70");
  send(data(2, of("cell/line")) + " 100");
  send_other(data(5, of("cell/station")) + " 110");
  send(data(3, of("cell/robot")) + " 10");
  send(data(1, of("cell/robot")) + " 9");
  EXPECT_TRUE(soon([&] { return samples() == 3; })) << samples();
  send(data(4, of("cell/line")) + " 11");
  EXPECT_TRUE(soon([&] { return samples() == 4; })) << samples();
}

TEST_F(DeceivedReader, RefusesALongSampleThatWouldHaveToWait) {
  const std::uint64_t before = participant_->refused();
  EXPECT_TRUE(soon([&] {
    send(data(2, std::vector<std::byte>(10000)));
    return participant_->refused() > before;
  }));
}

// A sample that cannot be decoded has no key, so that an assertion of Fast DDS 3 would end the process.
TEST_F(DeceivedReader, RefusesSamplesThatCannotBeDecoded) {
  for (std::uint64_t i = 1; i <= 3; ++i) send(data(i, std::vector<std::byte>(20, std::byte{0xff})));
  send(half(4, 1));
  send(half(4, 2));
  EXPECT_TRUE(soon([&] { return reader_->refused() >= 4; })) << reader_->refused();
  expect_that_the_gateway_works();
  EXPECT_EQ(received_, 0U);
}

// Fast DDS would handle this invalid sample once more after the reader has dropped it.
TEST_F(DeceivedReader, CountsASampleInOnePacketOnce) {
  send(fragments(1, 2, 100, 200));
  expect_that_the_gateway_works();
  EXPECT_EQ(samples(), 1U);
}

TEST_F(DeceivedReader, ForgetsTheFragmentsOfSamplesThatAGapSkips) {
  for (std::uint64_t i = 1; i <= 256; ++i) send(half(i, 1));
  send(gap(1, 257));
  send(half(257, 1));
  send(half(257, 2));
  EXPECT_TRUE(soon([&] { return samples() == 1; })) << samples();
}

TEST_F(DeceivedReader, ForgetsTheFragmentsOfASampleThatTheListOfAGapNames) {
  send(half(3, 1));
  send(gap(1, 2, {3}));
  send(data(2, bytes_of(FaultEvent{})));
  send(data(4, bytes_of(FaultEvent{})));
  EXPECT_TRUE(soon([&] { return samples() == 2; })) << samples();
}

TEST_F(DeceivedReader, ForgetsAWaitingSampleIfTheWriterSkipsManyNumbers) {
  constexpr std::uint64_t kFar = std::uint64_t{1} << 40;
  const auto sample = bytes_of(FaultEvent{});
  send(data(2, sample));
  send(heartbeat(kFar, 1000));
  for (std::uint64_t i = 0; i < 3; ++i) {
    send(data(kFar + i, sample));
    ASSERT_TRUE(soon([&] { return samples() == i + 1; })) << samples();
  }
}

TEST_F(DeceivedReader, KeepsTheFirst256SamplesOfWhichAFragmentIsMissing) {
  for (std::uint64_t i = 2; i <= 300; ++i) send(half(i, 1));
  send(half(1, 1));
  for (std::uint64_t i = 1; i <= 300; ++i) send(half(i, 2));
  EXPECT_TRUE(soon([&] { return samples() == 256; })) << samples();
  expect_that_the_gateway_works();
  EXPECT_EQ(samples(), 256U);
}

}  // namespace
}  // namespace takt::dds_test::gateway_test
