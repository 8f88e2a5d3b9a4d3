// Tests the inputs whose samples are replaced by a forced value.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include <takt/process.hpp>

#include "../../system/components/sample.hpp"

namespace takt::host::forced_input_test {
namespace {

using Sample = samples::Count;
constexpr std::int64_t kAlways = std::numeric_limits<std::int64_t>::max();
constexpr std::uint64_t kValue = 1'000'000;

/// A connected output and input. The parameter is true if samples are passed as objects.
class ForcedInput : public testing::TestWithParam<bool> {
 protected:
  void connect(bool safe = false) {
    const std::uint32_t most = PortType<Sample>::info.max_size;
    const channel::Link::Options options{
        .payload = GetParam() ? 0 : most, .safe = safe ? most : 0, .force = most};
    memory.resize(channel::Link::layout(options).size() / sizeof(Line));
    channel::Link::format(memory[0].data(), options);
    if (safe) link().give_safe(bytes_of(7));
    void* values = GetParam() ? out.make_values(link().buffers()) : nullptr;
    // The objects are never freed. This list keeps them reachable, so that the leak checker does not report
    // them.
    static auto& kept = *new std::vector<void*>;
    kept.push_back(values);
    next.stand_by();
    for (PortBase* port :
         {static_cast<PortBase*>(&out), static_cast<PortBase*>(&in), static_cast<PortBase*>(&next)}) {
      port->serve(context);
      port->connect(link(), values);
    }
  }
  channel::Link link() { return channel::Link{memory[0].data()}; }
  static std::vector<std::byte> bytes_of(std::uint64_t number) {
    Sample count;
    fill(count, number);
    std::vector<std::byte> bytes(PortType<Sample>::info.max_size);
    bytes.resize(PortType<Sample>::encode(count, bytes.data(), PortType<Sample>::info.max_size));
    return bytes;
  }
  bool force(std::uint64_t number = kValue, std::int64_t until_ns = kAlways) {
    return link().force(++forces, bytes_of(number), until_ns);
  }
  void write() {
    fill(sample, ++written);
    EXPECT_EQ(out.write(sample), Written::yes);
  }
  /// Begins the next run, reads, and returns the number of the new value. Returns 0 if nothing is new.
  std::uint64_t run() {
    context.start_ns += 1000;
    if (!in.read()) return 0;
    EXPECT_TRUE(in.is_new() && in.has_value() && is_whole(in.value()));
    return in.value().number();
  }

  struct alignas(64) Line : std::array<std::byte, 64> {};
  std::vector<Line> memory;
  PortContext context{.start_ns = 1};
  OutPort<Sample> out{"out"};
  InPort<Sample> in{"in"};
  InPort<Sample> next{"in"};
  Sample sample;
  std::uint64_t written = 0;
  std::uint32_t forces = 0;
};

TEST_P(ForcedInput, IsNewAndFreshInEachRunWhateverTheOutputWrites) {
  connect();
  write();
  EXPECT_EQ(run(), 1U);
  ASSERT_TRUE(force());
  EXPECT_TRUE(in.has_news());
  EXPECT_EQ(run(), kValue) << "the output has written nothing";
  write();
  EXPECT_EQ(run(), kValue);
  EXPECT_EQ(in.age().count(), 0);
  write();
  write();
  EXPECT_EQ(run(), kValue);
  EXPECT_EQ(link().block().taken.load(), 3U) << "the reader takes the samples as usual";
}

TEST_P(ForcedInput, HasOneNewValueInEachRunSoThatLoopsEnd) {
  connect();
  ASSERT_TRUE(force());
  EXPECT_EQ(run(), kValue);
  EXPECT_FALSE(in.has_news());
  EXPECT_FALSE(in.read());
  EXPECT_FALSE(in.is_new());
  EXPECT_EQ(in.value().number(), kValue);
  write();
  EXPECT_FALSE(in.read());
  EXPECT_EQ(in.value().number(), kValue);
}

TEST_P(ForcedInput, GetsTheLastSampleAgainWhenTheForceEnds) {
  connect();
  write();
  EXPECT_EQ(run(), 1U);
  ASSERT_TRUE(force());
  EXPECT_EQ(run(), kValue);
  link().end_force();
  EXPECT_TRUE(in.has_news());
  EXPECT_EQ(run(), 1U) << "the output may write rarely";
  EXPECT_GT(in.age().count(), 0);
  EXPECT_EQ(run(), 0U);
  ASSERT_TRUE(force(kValue + 1));
  write();
  EXPECT_EQ(run(), kValue + 1);
  link().end_force();
  EXPECT_EQ(run(), 2U) << "the sample that arrived meanwhile";
  write();
  EXPECT_EQ(run(), 3U);
}

TEST_P(ForcedInput, HasNoValueAfterTheForceIfNoSampleHasArrived) {
  connect();
  ASSERT_TRUE(force());
  EXPECT_EQ(run(), kValue);
  link().end_force();
  EXPECT_EQ(run(), 0U);
  EXPECT_FALSE(in.has_value());
  EXPECT_EQ(in.value().number(), 0U) << "the forced value must not stay";
}

TEST_P(ForcedInput, EndsTheForceByItselfWhenNobodyRenewsIt) {
  connect();
  write();
  ASSERT_TRUE(force(kValue, context.start_ns + 2500));
  EXPECT_EQ(run(), kValue);
  EXPECT_EQ(run(), kValue);
  EXPECT_EQ(run(), 1U) << "as if the node had died or had been stopped";
  EXPECT_EQ(run(), 0U);
}

TEST_P(ForcedInput, StaysForcedWhileTheForceIsRenewed) {
  connect();
  ASSERT_TRUE(force(kValue, context.start_ns + 2500));
  EXPECT_EQ(run(), kValue);
  link().renew_force(context.start_ns + 10'000);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(run(), kValue);
}

TEST_P(ForcedInput, GetsTheNextValueIfTwoForcesFollowEachOtherBetweenTwoRuns) {
  connect();
  ASSERT_TRUE(force());
  EXPECT_EQ(run(), kValue);
  link().end_force();
  ASSERT_TRUE(force(kValue + 3));
  EXPECT_EQ(run(), kValue + 3);
}

TEST_P(ForcedInput, HidesTheSafeValue) {
  connect(true);
  EXPECT_EQ(run(), 7U);
  EXPECT_TRUE(in.is_safe());
  ASSERT_TRUE(force());
  EXPECT_EQ(run(), kValue);
  EXPECT_FALSE(in.is_safe());
  link().end_force();
  EXPECT_EQ(run(), 7U);
  EXPECT_TRUE(in.is_safe());
}

TEST_P(ForcedInput, LeavesNoForcedValueToANewInstance) {
  connect();
  write();
  EXPECT_EQ(run(), 1U);
  ASSERT_TRUE(force());
  EXPECT_EQ(run(), kValue);
  link().end_force();  // the node ends the force before the swap, so the old instance may not have seen this
  next.take_over(in);
  EXPECT_EQ(next.value().number(), 1U);
  EXPECT_FALSE(next.read());
  EXPECT_EQ(next.value().number(), 1U);
}

INSTANTIATE_TEST_SUITE_P(Ways, ForcedInput, testing::Bool(),
                         [](const auto& way) { return way.param ? "Objects" : "Bytes"; });

class ForcedLink : public ForcedInput {};
INSTANTIATE_TEST_SUITE_P(Ways, ForcedLink, testing::Values(false), [](const auto&) { return "Bytes"; });

TEST_P(ForcedLink, AcceptsNoOtherValueWhileTheReaderDecodesTheLastOne) {
  connect();
  ASSERT_TRUE(force());
  bool tried = false;
  EXPECT_TRUE(link().read_force(1, [&](const std::byte*, std::uint32_t) {
    link().end_force();
    tried = !force(kValue + 1);
    return true;
  }));
  EXPECT_TRUE(tried);
  EXPECT_TRUE(force(kValue + 1));
  EXPECT_FALSE(link().read_force(1, [](const std::byte*, std::uint32_t) { return true; }))
      << "the bytes belong to another force now";
}

TEST_P(ForcedLink, AcceptsAValueAfterItsReaderDiedWhileItDecoded) {
  connect();
  ASSERT_TRUE(force());
  link().block().force_held.store(1);
  link().end_force();
  EXPECT_FALSE(force(kValue + 1));
  const channel::LinkReader successor{link()};
  EXPECT_TRUE(force(kValue + 1));
}

TEST_P(ForcedLink, RejectsATooLargeValue) {
  connect();
  const std::vector<std::byte> large(PortType<Sample>::info.max_size + 1);
  EXPECT_FALSE(link().force(1, large, kAlways));
  EXPECT_EQ(link().forced(), 0U);
}

}  // namespace
}  // namespace takt::host::forced_input_test
