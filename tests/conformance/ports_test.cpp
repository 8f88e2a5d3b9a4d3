// What a connection promises, whatever way its samples go. A way is a class that ties ports together; every
// claim is held for each. To add one, give it the functions of InHost and name it in Ways.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include <takt/channel/seat.hpp>
#include <takt/component.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/node/far_gateway.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/shared_memory.hpp>

#include "../system/components/sample.hpp"
#include "dds/domain.hpp"

namespace takt {
namespace {

using Sample = ::samples::Count;

struct Quality {
  std::uint32_t depth = 1;
  bool safe = false;
  Nanoseconds deadline{};

  [[nodiscard]] std::uint32_t safe_room() const { return safe ? PortType<Sample>::info.max_size : 0; }
};

/// A safe value that no writer ever writes.
Sample safe_sample() {
  Sample sample;
  sample.number(1'000'000);
  sample.same()[3] = -1;
  sample.few().push_back(7);
  return sample;
}
void give_safe(const channel::Link& link) {
  std::vector<std::byte> bytes(PortType<Sample>::info.max_size);
  bytes.resize(PortType<Sample>::encode(safe_sample(), bytes.data(), PortType<Sample>::info.max_size));
  link.give_safe(bytes);
}

/// One writer, one reader, and what lies between. Settles at once.
template <bool kObjects>
class Link {
 public:
  /// What was written can be read at once, under the writer's number.
  static constexpr bool kAtOnce = true;
  static constexpr Nanoseconds kTolerance{0};  ///< of an age
  static constexpr std::uint64_t kMany = 200'000;

  explicit Link(Quality quality) {
    const channel::Link::Options options{.depth = quality.depth,
                                         .payload = kObjects ? 0 : PortType<Sample>::info.max_size,
                                         .is_queue = quality.depth > 1,
                                         .deadline_ns = quality.deadline.count(),
                                         .safe = quality.safe_room()};
    memory_ = std::move(os::SharedMemory::create("takt-link", channel::Link::layout(options).size()).value());
    channel::Link::format(memory_.data(), options);
    if (kObjects) values_ = OutPort<Sample>{"any"}.make_values(link().buffers());
  }
  void connect(PortBase& port) { port.connect(link(), values_); }
  /// Returns once what was written can be read, or is lost.
  void settle() const {}
  [[nodiscard]] channel::Link at_reader() const { return link(); }
  [[nodiscard]] std::uint64_t dropped() const { return link().block().overwritten.load(); }
  [[nodiscard]] std::uint64_t unfit() const { return link().block().unfit.load(); }

 private:
  [[nodiscard]] channel::Link link() const { return channel::Link{memory_.data()}; }
  os::SharedMemory memory_;
  void* values_ = nullptr;
};

using InHost = Link<true>;  // objects in the memory of the host
using Ring = Link<false>;   // bytes in memory that is shared

/// Over DDS: a gateway here takes what is written, one in a program of its own gives it to the reader's link.
class BetweenDevices {
 public:
  static constexpr bool kAtOnce = false;
  static constexpr Nanoseconds kTolerance =
      std::chrono::milliseconds{100};  // two clocks are read one after the other
  static constexpr std::uint64_t kMany = 5'000;

  explicit BetweenDevices(Quality quality) {
    const channel::Link::Options options{.depth = quality.depth,
                                         .payload = PortType<Sample>::info.max_size,
                                         .is_queue = quality.depth > 1,
                                         .wake_bits = channel::kGatewayBit,
                                         .deadline_ns = quality.deadline.count(),
                                         .safe = quality.safe_room()};
    for (os::SharedMemory* memory : {&from_, &to_}) {
      *memory = os::SharedMemory::create("takt-link", channel::Link::layout(options).size()).value();
      channel::Link::format(memory->data(), options);
    }
    const dds::Flow flow{
        .topic = "takt/ports/" + std::to_string(++made_),
        .type = model::parse_type(PortType<Sample>::info.description).value(),
        .quality = {.reliable = true, .depth = quality.depth, .deadline = {}, .lifespan = {}}};
    setenv("TAKT_INTERFACE", "127.0.0.1", 1);  // of the other program
    out_ = gateway().add_outgoing(flow, link(from_)).value();
    far_ = node::FarGateway::start({.device = "test",
                                    .domain = domain(),
                                    .peers = {},
                                    .bell = &bell_memory(),
                                    .place = made_ % 31 + 1,
                                    .flows = {{.flow = flow, .outgoing = false, .links = {&to_}}}})
               .value();
    until([this] {
      return far_->opened() && gateway().health(out_).matched == 1 && far_->health(0).matched == 1;
    });
  }
  ~BetweenDevices() { gateway().remove(out_); }
  BetweenDevices(const BetweenDevices&) = delete;
  BetweenDevices& operator=(const BetweenDevices&) = delete;

  void connect(PortBase& port) {
    port.connect(link(port.direction() == PortDirection::out ? from_ : to_), nullptr);
  }
  void settle() {
    bell().rings.fetch_add(1);
    os::futex_wake(bell().rings, channel::kGatewayBit);
    const channel::LinkBlock& from = link(from_).block();
    until([&] {
      const std::uint64_t moved = gateway().health(out_).samples;
      return from.taken.load() + from.overwritten.load() == from.written.load() &&
             moved == from.taken.load() && link(to_).block().written.load() == moved;
    });
  }
  [[nodiscard]] channel::Link at_reader() const { return link(to_); }
  [[nodiscard]] std::uint64_t dropped() const {
    return link(from_).block().overwritten.load() + link(to_).block().overwritten.load();
  }
  [[nodiscard]] std::uint64_t unfit() const { return link(from_).block().unfit.load(); }

 private:
  static int domain() { return dds_test::domain() + 20; }
  static channel::Link link(const os::SharedMemory& memory) { return channel::Link{memory.data()}; }
  static os::SharedMemory& bell_memory() {
    static os::SharedMemory memory = os::SharedMemory::create("takt-bell", sizeof(channel::Bell)).value();
    return memory;
  }
  static channel::Bell& bell() { return *reinterpret_cast<channel::Bell*>(bell_memory().data()); }
  // For all tests of the process: it may have one participant.
  static dds::Gateway& gateway() {
    static const auto made =
        dds::Gateway::create(
            dds::Participant::create(
                {.name = "ports_test", .domain = domain(), .discovery = {}, .interfaces = {"127.0.0.1"}})
                .value(),
            bell())
            .value();
    return *made;
  }
  template <class Condition>
  void until(Condition condition) {
    const Instant end = os::now() + std::chrono::seconds{20};
    while (!condition()) {
      if (far_) far_->step(os::now());
      ASSERT_LT(os::now(), end) << "it does not settle";
      std::this_thread::sleep_for(std::chrono::milliseconds{1});
    }
  }

  static inline std::uint32_t made_ = 0;
  os::SharedMemory from_;
  os::SharedMemory to_;
  dds::Gateway::FlowId out_ = 0;
  std::unique_ptr<node::FarGateway> far_;
};

/// A module with an output, or with an input, that runs at a time.
struct Writer {
  Writer() { out.serve(context); }
  Written write(std::uint64_t number, std::int64_t start_ns = 1000) {
    context.start_ns = start_ns;
    fill(sample, number);
    return out.write(sample);
  }
  PortContext context;
  Sample sample;
  OutPort<Sample> out{"out"};
};
struct Reader {
  Reader() { in.serve(context); }
  std::vector<std::uint64_t> read_all() {
    std::vector<std::uint64_t> numbers;
    while (in.read()) numbers.push_back(is_whole(in.value()) ? in.value().number() : 0);
    return numbers;
  }
  PortContext context;
  InPort<Sample> in{"in"};
};
using Numbers = std::vector<std::uint64_t>;

template <class Way>
class Ports : public testing::Test {};
using Ways = testing::Types<InHost, Ring, BetweenDevices>;
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

TYPED_TEST(Ports, HoldTheLatestValue) {
  TypeParam way{Quality{}};
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  for (std::uint64_t i = 1; i <= 5; ++i) EXPECT_EQ(writer.write(i), Written::yes);
  way.settle();
  EXPECT_EQ(reader.read_all(), Numbers{5});
  EXPECT_EQ(reader.in.value().number(), 5U) << "it stays when nothing has come";
  EXPECT_TRUE(reader.in.has_value());
  EXPECT_FALSE(reader.in.is_new());
  if (TypeParam::kAtOnce) {
    EXPECT_EQ(reader.in.sequence(), 5U);
  }
}

TYPED_TEST(Ports, TellNewsBeforeAndAfterTheyAreRead) {
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

TYPED_TEST(Ports, KeepTheOrderOfAQueue) {
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

TYPED_TEST(Ports, DropTheOldestOfAFullQueueAndCountIt) {
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
    EXPECT_EQ(reader.in.sequence(), 6U) << "the gap tells what was dropped";
  }
  EXPECT_EQ(reader.read_all(), (Numbers{7, 8}));
  EXPECT_EQ(way.dropped(), 5U);
}

TYPED_TEST(Ports, TellTheAgeFromOneRunToTheOther) {
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
  EXPECT_TRUE(near(reader.in.age(), Nanoseconds{1'000'000'000})) << "it grows while nothing comes";
  reader.context.start_ns = start - 1'000'000'000;
  EXPECT_EQ(reader.in.age(), Nanoseconds{0}) << "a reader that began before the writer";
}

TYPED_TEST(Ports, ThatAreNotConnectedAreOrdinaryPorts) {
  Writer writer;
  Reader reader;
  EXPECT_FALSE(writer.out.connected());
  EXPECT_FALSE(reader.in.connected());
  EXPECT_EQ(writer.write(1), Written::yes);
  EXPECT_FALSE(reader.in.has_news());
  EXPECT_FALSE(reader.in.read());
}

TYPED_TEST(Ports, OfOneWriterReachAllReaders) {
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

TYPED_TEST(Ports, OfSeveralWritersShareAQueueInTurn) {
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

TYPED_TEST(Ports, GoOnWhereAReaderWasThatStartsAgain) {
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

TYPED_TEST(Ports, GoOnWhenAWriterStartsAgain) {
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
  EXPECT_EQ(reader.in.sequence(), 6U) << "the numbers go on";
}

TYPED_TEST(Ports, RefuseAValueBeyondItsBounds) {
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

bool is_safe_sample(const Sample& sample) {
  return sample.number() == 1'000'000 && sample.same()[3] == -1 && sample.few().size() == 1 &&
         sample.few()[0] == 7;
}

TYPED_TEST(Ports, BeginWithTheSafeValueWhileTheWriterDoesNotExecute) {
  TypeParam way{Quality{.safe = true}};
  give_safe(way.at_reader());
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  EXPECT_TRUE(reader.in.has_news());
  ASSERT_TRUE(reader.in.read()) << "it comes like a sample";
  EXPECT_TRUE(reader.in.is_safe());
  EXPECT_TRUE(reader.in.is_new());
  EXPECT_TRUE(reader.in.has_value());
  EXPECT_TRUE(is_safe_sample(reader.in.value()));
  EXPECT_FALSE(reader.in.read()) << "and once";
  EXPECT_FALSE(reader.in.is_new());
  EXPECT_FALSE(reader.in.has_news());
  EXPECT_TRUE(is_safe_sample(reader.in.value()));
  writer.write(1);
  way.settle();
  EXPECT_FALSE(reader.in.read()) << "what it writes meanwhile is not to be trusted";
  EXPECT_TRUE(is_safe_sample(reader.in.value()));
}

TYPED_TEST(Ports, GiveSamplesAgainFromTheFirstThatIsWrittenWhenItExecutes) {
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
  EXPECT_TRUE(reader.in.is_safe()) << "the old one is not given";
  writer.write(2);
  way.settle();
  ASSERT_TRUE(reader.in.read());
  EXPECT_FALSE(reader.in.is_safe());
  EXPECT_EQ(reader.in.value().number(), 2U);
  way.at_reader().trust();  // again, and nothing changes
  EXPECT_FALSE(reader.in.read());
  EXPECT_EQ(reader.in.value().number(), 2U);
}

TYPED_TEST(Ports, GiveTheSafeValueWhenTheWriterStops) {
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

TYPED_TEST(Ports, GiveTheSafeValueInPlaceOfASampleThatIsOlderThanTheDeadline) {
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
  EXPECT_FALSE(reader.in.is_safe()) << "as old as the deadline is not older";
  reader.context.start_ns = start + (kDeadline + kNear).count() + 1;
  EXPECT_TRUE(reader.in.has_news());
  ASSERT_TRUE(reader.in.read());
  EXPECT_TRUE(reader.in.is_safe());
  EXPECT_TRUE(is_safe_sample(reader.in.value()));
  reader.context.start_ns = start + (kDeadline - kNear).count();
  EXPECT_FALSE(reader.in.read());
  EXPECT_TRUE(reader.in.is_safe()) << "until a fresh one comes, whatever the clock does";
  writer.write(2, start);
  way.settle();
  reader.context.start_ns = start + 2 * (kDeadline + kNear).count();
  EXPECT_FALSE(reader.in.read()) << "which this is not";
  EXPECT_TRUE(is_safe_sample(reader.in.value()));
  writer.write(3, start + 1'000'000);
  way.settle();
  reader.context.start_ns = start + (kDeadline - kNear).count();
  ASSERT_TRUE(reader.in.read());
  EXPECT_FALSE(reader.in.is_safe());
  EXPECT_EQ(reader.in.value().number(), 3U);
}

TYPED_TEST(Ports, AreAsWithoutASafeValueUntilItIsKnown) {
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

TYPED_TEST(Ports, NeverShowWhatWasWrittenWhileTheWriterDidNotExecute) {
  TypeParam way{Quality{.safe = true}};
  if (!TypeParam::kAtOnce) GTEST_SKIP() << "samples under way are of before or after";
  give_safe(way.at_reader());
  Writer writer;
  Reader reader;
  way.connect(writer.out);
  way.connect(reader.in);
  std::atomic<bool> over{false};
  std::thread thread{[&] {
    std::uint64_t number = 0;  // those that are odd are written by a module that executes
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
    EXPECT_EQ(seen.last, kSamples) << "the newest is never lost";
    EXPECT_EQ(seen.read + way.dropped(), kSamples);
  }
}

// Of bytes alone, which outlive a process.
TEST(RingPorts, GiveTheLatestValueToANewInstanceOfTheReader) {
  for (const bool is_queue : {false, true}) {
    Ring ring{Quality{.depth = is_queue ? 4U : 1U}};
    Writer writer;
    ring.connect(writer.out);
    {
      Reader first;
      ring.connect(first.in);
      EXPECT_FALSE(first.in.read()) << "nothing was ever written";
      writer.write(1);
      EXPECT_EQ(first.read_all(), Numbers{1});
    }
    {
      Reader second;
      ring.connect(second.in);
      EXPECT_EQ(second.read_all(), Numbers{}) << "it was read";
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

// Of bytes alone: what comes from elsewhere may be anything.
TEST(RingPorts, PassOverBytesThatAreNoSampleAndKeepTheLastOne) {
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
}  // namespace takt
