// Tests ports with a safe value. Readers get the safe value while the writer is not in EXECUTING.
#include "ways.hpp"

namespace takt::safe_ports_test {
namespace {

bool is_safe_sample(const Sample& sample) {
  return sample.number() == 1'000'000 && sample.same()[3] == -1 && sample.few().size() == 1 &&
         sample.few()[0] == 7;
}

template <class Way>
class SafePorts : public testing::Test {};
TYPED_TEST_SUITE(SafePorts, Ways);

TYPED_TEST(SafePorts, StartWithTheSafeValueWhileTheWriterDoesNotExecute) {
  TypeParam way{Quality{.safe = true}};
  give_safe(way.at_reader());
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  EXPECT_TRUE(reader.in.has_news());
  ASSERT_TRUE(reader.in.read()) << "the safe value arrives like a sample";
  EXPECT_TRUE(reader.in.is_safe());
  EXPECT_TRUE(reader.in.is_new());
  EXPECT_TRUE(reader.in.has_value());
  EXPECT_TRUE(is_safe_sample(reader.in.value()));
  EXPECT_FALSE(reader.in.read()) << "the safe value arrives once";
  EXPECT_FALSE(reader.in.is_new());
  EXPECT_FALSE(reader.in.has_news());
  EXPECT_TRUE(is_safe_sample(reader.in.value()));
  writer.write(1);
  way.settle();
  EXPECT_FALSE(reader.in.read()) << "samples that the writer writes before EXECUTING are not trusted";
  EXPECT_TRUE(is_safe_sample(reader.in.value()));
}

TYPED_TEST(SafePorts, DeliverSamplesAgainOnceTheWriterExecutes) {
  TypeParam way{Quality{.safe = true}};
  give_safe(way.at_reader());
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  writer.write(1);
  way.settle();
  way.at_reader().trust();
  ASSERT_TRUE(reader.in.read());
  EXPECT_TRUE(reader.in.is_safe()) << "the old sample is withheld";
  writer.write(2);
  way.settle();
  ASSERT_TRUE(reader.in.read());
  EXPECT_FALSE(reader.in.is_safe());
  EXPECT_EQ(reader.in.value().number(), 2U);
  way.at_reader().trust();  // a second call of trust() changes nothing
  EXPECT_FALSE(reader.in.read());
  EXPECT_EQ(reader.in.value().number(), 2U);
}

TYPED_TEST(SafePorts, SwitchToTheSafeValueWhenTheWriterStops) {
  TypeParam way{Quality{.safe = true}};
  give_safe(way.at_reader());
  way.at_reader().trust();
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  for (std::uint64_t round = 1; round <= 3; ++round) {
    way.at_reader().trust();
    writer.write(round);
    way.settle();
    ASSERT_TRUE(reader.in.read());
    EXPECT_EQ(reader.in.value().number(), round);
    way.at_reader().withhold();
    EXPECT_TRUE(reader.in.has_news());
    ASSERT_TRUE(reader.in.read());
    EXPECT_TRUE(is_safe_sample(reader.in.value()));
    EXPECT_FALSE(reader.in.read());
  }
}

TYPED_TEST(SafePorts, ReplaceASampleOlderThanTheDeadlineByTheSafeValue) {
  constexpr Nanoseconds kDeadline = std::chrono::seconds{1};
  constexpr Nanoseconds kNear = TypeParam::kTolerance;
  TypeParam way{Quality{.safe = true, .deadline = kDeadline}};
  give_safe(way.at_reader());
  way.at_reader().trust();
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  const std::int64_t start = to_ns(os::now());
  writer.write(1, start);
  way.settle();
  reader.context.start_ns = start + (kDeadline - kNear).count();
  ASSERT_TRUE(reader.in.read());
  EXPECT_FALSE(reader.in.is_safe()) << "a sample exactly as old as the deadline is valid";
  reader.context.start_ns = start + (kDeadline + kNear).count() + 1;
  EXPECT_TRUE(reader.in.has_news());
  ASSERT_TRUE(reader.in.read());
  EXPECT_TRUE(reader.in.is_safe());
  EXPECT_TRUE(is_safe_sample(reader.in.value()));
  reader.context.start_ns = start + (kDeadline - kNear).count();
  EXPECT_FALSE(reader.in.read());
  EXPECT_TRUE(reader.in.is_safe())
      << "the safe value stays until a fresh sample arrives, even if time goes back";
  writer.write(2, start);
  way.settle();
  reader.context.start_ns = start + 2 * (kDeadline + kNear).count();
  EXPECT_FALSE(reader.in.read()) << "this sample is not fresh";
  EXPECT_TRUE(is_safe_sample(reader.in.value()));
  writer.write(3, start + 1'000'000);
  way.settle();
  reader.context.start_ns = start + (kDeadline - kNear).count();
  ASSERT_TRUE(reader.in.read());
  EXPECT_FALSE(reader.in.is_safe());
  EXPECT_EQ(reader.in.value().number(), 3U);
}

TYPED_TEST(SafePorts, DeliverSamplesUntilTheReaderGetsASafeValue) {
  TypeParam way{Quality{.safe = true}};
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  EXPECT_FALSE(reader.in.read());
  writer.write(1);
  way.settle();
  ASSERT_TRUE(reader.in.read());
  EXPECT_FALSE(reader.in.is_safe());
  give_safe(way.at_reader());
  ASSERT_TRUE(reader.in.read());
  EXPECT_TRUE(is_safe_sample(reader.in.value()));
}

TYPED_TEST(SafePorts, NeverShowSamplesWrittenWhileTheWriterDidNotExecute) {
  TypeParam way{Quality{.safe = true}};
  if (!TypeParam::kAtOnce)
    GTEST_SKIP() << "a sample in transit may have been written before or after the change";
  give_safe(way.at_reader());
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  std::atomic<bool> over{false};
  std::thread thread{[&] {
    std::uint64_t number = 0;  // odd numbers are written while the link is trusted, even ones while it is not
    for (std::uint64_t round = 0; round < TypeParam::kMany / 10; ++round) {
      way.at_reader().trust();
      for (int i = 0; i < 5; ++i) writer.write(number += number % 2 == 0 ? 1 : 2);
      way.at_reader().withhold();
      ++number;
      writer.write(number);
    }
    over = true;
  }};
  std::uint64_t safe = 0;
  std::uint64_t live = 0;
  std::uint64_t wrong = 0;
  std::uint64_t last = 0;
  while (!over) {
    const bool found = reader.in.read();
    const Sample& sample = reader.in.value();
    if (reader.in.is_safe()) {
      safe += found ? 1 : 0;
      wrong += is_safe_sample(sample) ? 0 : 1;
    } else {
      live += found ? 1 : 0;
      wrong += is_whole(sample) && sample.number() % 2 == 1 && (!found || sample.number() > last) ? 0 : 1;
      last = sample.number();
    }
  }
  thread.join();
  EXPECT_EQ(wrong, 0U);
  reader.in.read();
  EXPECT_TRUE(is_safe_sample(reader.in.value()));
  this->RecordProperty("safe", static_cast<int>(safe));
  this->RecordProperty("live", static_cast<int>(live));
}

}  // namespace
}  // namespace takt::safe_ports_test
