// Tests that the ports of a new instance can take over from the ports of the old instance, and that the old
// ports can then take back the connection.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <memory>
#include <random>
#include <vector>

#include <takt/process.hpp>

#include "../../system/components/sample.hpp"

namespace takt::host::port_take_over_test {
namespace {

using Sample = samples::Count;

/// A link with two outputs and two inputs. The second output and the second input stand by, and can take over
/// from the first output and the first input. The parameter is true if samples are passed as objects.
class PortTakeOver : public testing::TestWithParam<bool> {
 protected:
  void connect(std::uint32_t depth, bool safe = false) {
    const std::uint32_t most = PortType<Sample>::info.max_size;
    const channel::Link::Options options{
        .depth = depth, .payload = GetParam() ? 0 : most, .is_queue = depth > 1, .safe = safe ? most : 0};
    memory.resize(channel::Link::layout(options).size() / sizeof(Line));
    channel::Link::format(memory[0].data(), options);
    void* values = GetParam() ? out[0].make_values(link().buffers()) : nullptr;
    // The objects are never freed. This list keeps them reachable, so that the leak checker does not report
    // them.
    static auto& kept = *new std::vector<void*>;
    kept.push_back(values);
    out[1].stand_by();
    in[1].stand_by();
    for (std::size_t i = 0; i < 2; ++i) {
      out[i].serve(context);
      in[i].serve(context);
      out[i].connect(link(), values);
      in[i].connect(link(), values);
    }
  }
  channel::Link link() { return channel::Link{memory[0].data()}; }
  void write(std::size_t by) {
    fill(sample, ++written);
    EXPECT_EQ(out[by].write(sample), Written::yes);
  }
  /// Reads the next sample and returns its number. Returns 0 if there is no new sample.
  std::uint64_t read(std::size_t by) {
    if (!in[by].read()) return 0;
    EXPECT_TRUE(is_whole(in[by].value()));
    EXPECT_EQ(in[by].sequence(), in[by].value().number());
    return in[by].value().number();
  }

  struct alignas(64) Line : std::array<std::byte, 64> {};
  std::vector<Line> memory;
  PortContext context{.start_ns = 1};
  std::array<OutPort<Sample>, 2> out{OutPort<Sample>{"out"}, OutPort<Sample>{"out"}};
  std::array<InPort<Sample>, 2> in{InPort<Sample>{"in"}, InPort<Sample>{"in"}};
  Sample sample;
  std::uint64_t written = 0;
};

TEST_P(PortTakeOver, KeepsTheLastValueAndAllUnreadSamples) {
  connect(4);
  for (int i = 0; i < 3; ++i) write(0);
  EXPECT_EQ(read(0), 1U);
  in[1].take_over(in[0]);
  EXPECT_TRUE(in[1].has_value());
  EXPECT_FALSE(in[1].is_new());
  EXPECT_EQ(in[1].value().number(), 1U);
  EXPECT_EQ(in[1].sequence(), 1U);
  out[1].take_over(out[0]);
  write(1);
  for (const std::uint64_t number : {2U, 3U, 4U, 0U}) EXPECT_EQ(read(1), number);

  in[0].take_over(in[1]);
  out[0].take_over(out[1]);
  EXPECT_EQ(in[0].value().number(), 4U) << "the value that the other instance read";
  write(0);
  EXPECT_EQ(read(0), 5U);
  EXPECT_EQ(read(0), 0U);
}

TEST_P(PortTakeOver, KeepsTheLatestValueEvenIfItIsNotSentAgain) {
  connect(1);
  write(0);
  EXPECT_EQ(read(0), 1U);
  in[1].take_over(in[0]);
  EXPECT_FALSE(in[1].read());
  EXPECT_EQ(in[1].value().number(), 1U);
  EXPECT_TRUE(is_whole(in[1].value()));
}

TEST_P(PortTakeOver, GivesNoValueBeforeTheFirstSample) {
  connect(1);
  in[1].take_over(in[0]);
  EXPECT_FALSE(in[1].has_value());
  out[1].take_over(out[0]);
  write(1);
  EXPECT_EQ(read(1), 1U);
}

TEST_P(PortTakeOver, KeepsASafeValue) {
  connect(1, true);
  Sample safe;
  fill(safe, 1'000'000);
  std::vector<std::byte> bytes(PortType<Sample>::info.max_size);
  bytes.resize(PortType<Sample>::encode(safe, bytes.data(), static_cast<std::uint32_t>(bytes.size())));
  link().give_safe(bytes);
  EXPECT_TRUE(in[0].read());
  ASSERT_TRUE(in[0].is_safe());
  in[1].take_over(in[0]);
  EXPECT_TRUE(in[1].is_safe());
  EXPECT_FALSE(in[1].read()) << "the takeover itself delivered the safe value";
  EXPECT_EQ(in[1].value().number(), 1'000'000U);
  link().trust();
  out[1].take_over(out[0]);
  write(1);
  EXPECT_TRUE(in[1].read());
  EXPECT_FALSE(in[1].is_safe());
  EXPECT_EQ(in[1].value().number(), 1U);
}

TEST_P(PortTakeOver, LosesNoSampleOverThousandsOfTakeovers) {
  connect(8);
  std::mt19937 random{7};
  std::size_t writer = 0;
  std::size_t reader = 0;
  std::uint64_t last = 0;
  for (int n = 0; n < 100'000; ++n) {
    switch (random() % 4) {
      case 0:
        if (written - last < 8) write(writer);
        break;
      case 1:
        if (const std::uint64_t number = read(reader); number != 0) {
          ASSERT_EQ(number, last + 1);
          last = number;
        } else {
          ASSERT_EQ(last, written);
        }
        break;
      case 2:
        out[1 - writer].take_over(out[writer]);
        writer = 1 - writer;
        break;
      case 3:
        in[1 - reader].take_over(in[reader]);
        reader = 1 - reader;
        ASSERT_EQ(in[reader].has_value() ? in[reader].value().number() : 0, last);
        break;
    }
  }
  EXPECT_GT(last, 10'000U);
  EXPECT_EQ(link().block().overwritten.load(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Ways, PortTakeOver, testing::Bool(),
                         [](const auto& way) { return way.param ? "AsObjects" : "AsBytes"; });

}  // namespace
}  // namespace takt::host::port_take_over_test
