// Tests ports that have no safe value.
#include "ways.hpp"

namespace takt::ports_test {
namespace {

template <class Way>
class Ports : public testing::Test {};
TYPED_TEST_SUITE(Ports, Ways);

TYPED_TEST(Ports, HaveNoValueBeforeTheFirstSample) {
  TypeParam way{Quality{}};
  Reader reader;
  way.connect(reader.in);
  EXPECT_TRUE(reader.in.connected());
  EXPECT_FALSE(reader.in.has_news());
  EXPECT_FALSE(reader.in.read());
  EXPECT_FALSE(reader.in.has_value());
  EXPECT_FALSE(reader.in.is_new());
  EXPECT_EQ(reader.in.value().number(), 0U);
  EXPECT_EQ(reader.in.sequence(), 0U);
  EXPECT_EQ(reader.in.age(), Nanoseconds::max());
}

TYPED_TEST(Ports, HoldTheLatestValueUntilANewSampleArrives) {
  TypeParam way{Quality{}};
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  for (std::uint64_t i = 1; i <= 5; ++i) EXPECT_EQ(writer.write(i), Written::yes);
  way.settle();
  EXPECT_EQ(reader.read_all(), Numbers{5});
  EXPECT_EQ(reader.in.value().number(), 5U) << "the value stays if nothing new has arrived";
  EXPECT_TRUE(reader.in.has_value());
  EXPECT_FALSE(reader.in.is_new());
  if (TypeParam::kAtOnce) {
    EXPECT_EQ(reader.in.sequence(), 5U);
  }
}

TYPED_TEST(Ports, ReportWhetherThereIsANewSample) {
  TypeParam way{Quality{}};
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  writer.write(1);
  way.settle();
  EXPECT_TRUE(reader.in.has_news());
  EXPECT_TRUE(reader.in.read());
  EXPECT_TRUE(reader.in.is_new());
  EXPECT_FALSE(reader.in.has_news());
}

TYPED_TEST(Ports, DeliverTheSamplesOfAQueueInOrder) {
  TypeParam way{Quality{.depth = 7}};
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  for (std::uint64_t i = 1; i <= 7; ++i) writer.write(i);
  way.settle();
  EXPECT_EQ(reader.read_all(), (Numbers{1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(way.dropped(), 0U);
}

TYPED_TEST(Ports, DropAndCountTheOldestSamplesOfAFullQueue) {
  TypeParam way{Quality{.depth = 3}};
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  for (std::uint64_t i = 1; i <= 8; ++i) writer.write(i);
  way.settle();
  ASSERT_TRUE(reader.in.read());
  EXPECT_EQ(reader.in.value().number(), 6U);
  if (TypeParam::kAtOnce) {
    EXPECT_EQ(reader.in.sequence(), 6U) << "the gap in the numbers shows how many samples were dropped";
  }
  EXPECT_EQ(reader.read_all(), (Numbers{7, 8}));
  EXPECT_EQ(way.dropped(), 5U);
}

TYPED_TEST(Ports, MeasureTheAgeOfASampleFromTheWritersRunToTheReadersRun) {
  TypeParam way{Quality{}};
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  const std::int64_t start = to_ns(os::now() - std::chrono::seconds{1});
  const auto near = [](Nanoseconds age, Nanoseconds expected) {
    return age >= expected - TypeParam::kTolerance && age <= expected + TypeParam::kTolerance;
  };
  writer.write(1, start);
  way.settle();
  reader.context.start_ns = start + 300'000'000;
  ASSERT_TRUE(reader.in.read());
  EXPECT_TRUE(near(reader.in.age(), Nanoseconds{300'000'000})) << to_text(reader.in.age());
  reader.context.start_ns = start + 1'000'000'000;
  EXPECT_TRUE(near(reader.in.age(), Nanoseconds{1'000'000'000})) << "the age grows while nothing arrives";
  reader.context.start_ns = start - 1'000'000'000;
  EXPECT_EQ(reader.in.age(), Nanoseconds{0}) << "the reader's run began before the writer's";
}

TYPED_TEST(Ports, CanBeUsedWithoutAConnection) {
  Writer writer;
  Reader reader;
  EXPECT_FALSE(writer.out.connected());
  EXPECT_FALSE(reader.in.connected());
  EXPECT_EQ(writer.write(1), Written::yes);
  EXPECT_FALSE(reader.in.has_news());
  EXPECT_FALSE(reader.in.read());
}

TYPED_TEST(Ports, DeliverTheSamplesOfOneWriterToAllReaders) {
  TypeParam first{Quality{}};
  TypeParam second{Quality{.depth = 4}};
  Writer writer;
  Reader latest;
  Reader queue;
  first.connect(writer.out);
  second.connect(writer.out);
  first.connect(latest.in);
  second.connect(queue.in);
  for (std::uint64_t i = 1; i <= 3; ++i) writer.write(i);
  first.settle();
  second.settle();
  EXPECT_EQ(latest.read_all(), Numbers{3});
  EXPECT_EQ(queue.read_all(), (Numbers{1, 2, 3}));
}

TYPED_TEST(Ports, InterleaveTheSamplesOfSeveralWritersInOneQueue) {
  TypeParam first{Quality{.depth = 4}};
  TypeParam second{Quality{.depth = 4}};
  Writer one;
  Writer two;
  Reader reader;
  first.connect(one.out);
  second.connect(two.out);
  first.connect(reader.in);
  second.connect(reader.in);
  for (std::uint64_t i = 1; i <= 3; ++i) one.write(i);
  for (std::uint64_t i = 11; i <= 12; ++i) two.write(i);
  first.settle();
  second.settle();
  EXPECT_EQ(reader.read_all(), (Numbers{1, 11, 2, 12, 3}));
}

TYPED_TEST(Ports, LetARestartedReaderContinueAfterTheLastSampleItRead) {
  TypeParam way{Quality{.depth = 8}};
  Writer writer;
  way.connect(writer.out);
  for (std::uint64_t i = 1; i <= 4; ++i) writer.write(i);
  way.settle();
  {
    Reader reader;
    way.connect(reader.in);
    ASSERT_TRUE(reader.in.read());
    ASSERT_TRUE(reader.in.read());
  }
  writer.write(5);
  way.settle();
  Reader reader;
  way.connect(reader.in);
  EXPECT_EQ(reader.read_all(), (Numbers{3, 4, 5}));
}

TYPED_TEST(Ports, DeliverAllSamplesOfAWriterThatRestarts) {
  TypeParam way{Quality{.depth = 8}};
  Reader reader;
  way.connect(reader.in);
  for (std::uint64_t life = 0; life < 3; ++life) {
    Writer writer;
    way.connect(writer.out);
    writer.write(life * 10 + 1);
    writer.write(life * 10 + 2);
  }
  way.settle();
  EXPECT_EQ(reader.read_all(), (Numbers{1, 2, 11, 12, 21, 22}));
  EXPECT_EQ(reader.in.sequence(), 6U) << "the numbers continue over the restarts";
}

TYPED_TEST(Ports, RejectASampleThatExceedsTheBoundsOfItsType) {
  TypeParam way{Quality{}};
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  fill(writer.sample, 4);
  writer.sample.few().resize(5);
  EXPECT_EQ(writer.out.write(writer.sample), Written::unfit);
  way.settle();
  EXPECT_FALSE(reader.in.read());
  EXPECT_EQ(way.unfit(), 1U);
}

TYPED_TEST(Ports, NeverShowATornSample) {
  for (const std::uint32_t depth : {1U, 5U}) {
    TypeParam way{Quality{.depth = depth}};
    Writer writer;
    Reader reader;
    way.connect(writer.out);
    way.connect(reader.in);
    std::atomic<bool> over{false};
    constexpr std::uint64_t kSamples = TypeParam::kMany;
    std::thread thread{[&] {
      for (std::uint64_t i = 1; i <= kSamples; ++i) writer.write(i);
      over = true;
    }};
    Seen seen;
    while (seen.last != kSamples) {
      const bool last_look = over;
      if (reader.in.read())
        seen.take(reader.in.value(), 0);
      else if (last_look && TypeParam::kAtOnce)
        break;
      else if (last_look)
        way.settle();
    }
    thread.join();
    EXPECT_EQ(seen.wrong, 0U);
    EXPECT_EQ(seen.last, kSamples) << "the newest sample is never lost";
    EXPECT_EQ(seen.read + way.dropped(), kSamples);
  }
}

// Tests only links that hold bytes in shared memory, because these links outlive a process.
TEST(RingPorts, KeepTheLatestValueForANewInstanceOfTheReader) {
  for (const bool is_queue : {false, true}) {
    Ring ring{Quality{.depth = is_queue ? 4U : 1U}};
    Writer writer;
    ring.connect(writer.out);
    {
      Reader first;
      ring.connect(first.in);
      EXPECT_FALSE(first.in.read()) << "nothing was written yet";
      writer.write(1);
      EXPECT_EQ(first.read_all(), Numbers{1});
    }
    {
      Reader second;
      ring.connect(second.in);
      EXPECT_EQ(second.read_all(), Numbers{}) << "the first instance has read the sample";
      EXPECT_EQ(second.in.has_value(), !is_queue);
      EXPECT_EQ(second.in.sequence(), is_queue ? 0U : 1U);
      EXPECT_EQ(second.in.value().number(), is_queue ? 0U : 1U);
    }
    writer.write(2);
    Reader third;
    ring.connect(third.in);
    EXPECT_EQ(third.read_all(), Numbers{2});
    EXPECT_TRUE(is_whole(third.in.value()));
  }
}

// Tests only links that hold bytes in shared memory, because another process can write invalid bytes into
// them.
TEST(RingPorts, SkipInvalidBytesAndKeepTheLastSample) {
  const channel::Link::Options options{
      .depth = 4, .payload = PortType<Sample>::info.max_size, .is_queue = true};
  auto memory =
      std::move(os::SharedMemory::create("takt-link", channel::Link::layout(options).size()).value());
  channel::Link::format(memory.data(), options);
  const channel::Link link{memory.data()};
  channel::LinkWriter bytes{link};
  Reader reader;
  reader.in.connect(link, nullptr);
  Sample sample;
  fill(sample, 7);
  bytes.publish(PortType<Sample>::encode(sample, link.payload(bytes.buffer()), link.stride()), 1);
  link.payload(bytes.buffer())[1] = std::byte{9};
  bytes.publish(20, 1);
  EXPECT_EQ(reader.read_all(), Numbers{7});
  EXPECT_TRUE(is_whole(reader.in.value()));
  EXPECT_EQ(link.block().refused.load(), 1U);
}

}  // namespace
}  // namespace takt::ports_test
