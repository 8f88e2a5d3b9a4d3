// Tests of the gateway, which moves samples between the links of a device and DDS. Another process is at the
// other end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <takt/channel/link.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>

#include "domain.hpp"
#include "peer.hpp"
#include "sample.hpp"

namespace takt::dds_test::gateway_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// The memory of a link, formatted as the node formats it.
class Memory {
 public:
  explicit Memory(channel::Link::Options options) : size_(channel::Link::layout(options).size()) {
    bytes_ = static_cast<std::byte*>(::operator new (size_, std::align_val_t{64}));
    std::memset(bytes_, 0, size_);
    channel::Link::format(bytes_, options);
  }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory() { ::operator delete (bytes_, std::align_val_t{64}); }
  [[nodiscard]] channel::Link link() const { return channel::Link{bytes_}; }

 private:
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

  /// Writes a sample as a module does, and wakes its readers as the executor does at the end of the cycle.
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
  /// Writes sample 0 until the peer receives it: the peer's reader may match later than this writer.
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
  for (std::uint64_t number = 1; number <= 500; ++number) {
    write(writer, bytes_of(number, 0, static_cast<std::uint32_t>(number * 37 % 5000)));
    std::this_thread::sleep_for(1ms);
  }
  ASSERT_TRUE(tap.says("sample 1"));
  for (std::uint64_t number = 2; number <= 500; ++number)
    ASSERT_EQ(tap.line(), "sample " + std::to_string(number));
  EXPECT_EQ(health(*flow_id).failures, 0U);
  EXPECT_EQ(memory.link().block().overwritten.load(), 0U);
}

TEST_F(DdsGateway, ReceivesCompleteSamplesInOrderWithTheirTimeStamps) {
  const Memory memory{queue(256)};
  const Memory latest{{.depth = 1, .payload = kPayload}};
  const auto flow_id = gateway_->add_incoming(flow("in", kReliable), {memory.link(), latest.link()});
  ASSERT_TRUE(flow_id.ok());
  Peer feed{{"feed", "in", "reliable", "64"}};
  ASSERT_TRUE(feed.says("ready"));
  ASSERT_TRUE(soon([&] { return health(*flow_id).matched == 1; }));
  std::this_thread::sleep_for(300ms);  // waits until the writer has matched too
  const std::int64_t begin = to_ns(os::now());
  feed.say("200");
  ASSERT_TRUE(soon([&] { return health(*flow_id).samples == 200; }));
  const std::int64_t end = to_ns(os::now());
  channel::LinkReader reader{memory.link()};
  std::int64_t last = begin - 1'000'000;  // tolerance: the wall clock may be corrected
  for (std::uint64_t number = 1; number <= 200; ++number) {
    ASSERT_TRUE(reader.take());
    const std::byte* bytes = reader.link().payload(reader.buffer());
    EXPECT_TRUE(is_whole(bytes, reader.info().size));
    EXPECT_EQ(number_in(bytes), number);
    EXPECT_GE(reader.info().stamp_ns, last);
    EXPECT_LE(reader.info().stamp_ns, end);
    last = reader.info().stamp_ns - 100'000;  // the two clocks are not read at the same instant
  }
  channel::LinkReader newest{latest.link()};
  ASSERT_TRUE(newest.take());
  EXPECT_EQ(number_in(newest.link().payload(newest.buffer())), 200U);
  EXPECT_EQ(health(*flow_id).lost, 0U);
}

TEST_F(DdsGateway, KeepsTheTimeStampOfTheModuleUnlessItsClockIsWrong) {
  const Memory out{queue(4, kWake)};
  const Memory in{queue(4)};
  const auto going = gateway_->add_outgoing(flow("stamp", kReliable), out.link());
  const auto coming = gateway_->add_incoming(flow("stamp", kReliable), {in.link()});
  ASSERT_TRUE(going.ok() && coming.ok());
  ASSERT_TRUE(soon([&] { return health(*going).matched == 1 && health(*coming).matched == 1; }));
  channel::LinkWriter writer{out.link()};
  const std::int64_t now = to_ns(os::now());
  write(writer, bytes_of(1), now - 7'000'000'000);
  write(writer, bytes_of(2), now - 100'000'000'000);  // as from a module whose clock is wrong
  ASSERT_TRUE(soon([&] { return health(*coming).samples == 2; }));
  channel::LinkReader reader{in.link()};
  ASSERT_TRUE(reader.take());
  EXPECT_NEAR(static_cast<double>(reader.info().stamp_ns), static_cast<double>(now - 7'000'000'000), 5e6);
  ASSERT_TRUE(reader.take());
  EXPECT_GE(reader.info().stamp_ns, now) << "the gateway uses the time of arrival instead";
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
        os::futex_wait(wake_word_.rings, rings, channel::kSporadicBit, os::now() + 20s);
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
  EXPECT_TRUE(soon([&] { return woken == 100; }, 5s)) << woken;
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
  good.resize(48);  // the sample claims 40 bytes of data but has none, so every variant is too short
  Peer forger{{"forge", "in", "test::Sample", "plain", "500", good}};
  ASSERT_TRUE(forger.says("forged", 60s));
  const wire::FlowHealth after = health(*flow_id);
  EXPECT_EQ(after.refused + after.samples, 500U);
  EXPECT_GT(after.refused, 300U);
  EXPECT_EQ(after.lost, 0U) << "rejected samples do not count as lost";
  EXPECT_EQ(memory.link().block().written.load(), after.samples);
  Peer honest{{"feed", "in", "reliable", "64"}};
  EXPECT_TRUE(soon([&] {
    honest.say("1");
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
  ASSERT_TRUE(live.says("sample 1000", 5s));
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
  ASSERT_TRUE(tap.says("sample 1"));
  for (std::uint64_t number = 2; number <= 3000; ++number)
    ASSERT_EQ(tap.line(), "sample " + std::to_string(number));
}

TEST_F(DdsGateway, ReportsTheQosPolicyThatPreventsAMatch) {
  const Memory out{queue(8, kWake)};
  const auto going = gateway_->add_outgoing(flow("quality"), out.link());
  ASSERT_TRUE(going.ok());
  Peer tap{{"tap", "quality", "reliable", "8"}};
  ASSERT_TRUE(tap.says("ready"));
  EXPECT_TRUE(soon([&] { return health(*going).incompatible == "reliability"; }));
  EXPECT_EQ(health(*going).matched, 0U);
  EXPECT_TRUE(soon([&] {
    tap.say("health");
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
  ASSERT_TRUE(tap.says("ready"));
  channel::LinkWriter writer{memory.link()};
  std::uint64_t number = 0;
  std::optional<std::string> first;
  ASSERT_TRUE(soon([&] {
    write(writer, bytes_of(++number));
    return (first = tap.line(20ms)).has_value();
  }));
  tap.signal(SIGSTOP);  // samples that do not fit into its socket's 4 MB are dropped
  for (int i = 0; i < 300; ++i) {
    write(writer, bytes_of(++number, 0, 50000));
    std::this_thread::sleep_for(1ms);
  }
  tap.signal(SIGCONT);
  ASSERT_TRUE(soon([&] {
    write(writer, bytes_of(++number));
    return tap.says("sample " + std::to_string(number), 100ms);
  }));
  tap.say("health");
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
  // The first samples may be overwritten: the link has room for 4.
  ASSERT_TRUE(soon([&] { return health(*coming).samples == 6; })) << health(*coming).samples;
  EXPECT_EQ(health(*coming).refused, 0U);
  std::uint64_t last = 0;
  while (reader.take()) {
    last = number_in(reader.link().payload(reader.buffer()));
    EXPECT_TRUE(is_whole(reader.link().payload(reader.buffer()), reader.info().size)) << last;
  }
  EXPECT_EQ(last, kMostData);
}

}  // namespace
}  // namespace takt::dds_test::gateway_test
