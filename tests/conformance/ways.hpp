// The ways in which a connection can carry samples. Each way is a class that connects ports. Every typed test
// runs once for each way. To add a way, write a class with the same functions as InHost and add it to Ways.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include <long_enough.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/component.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/node/bridge.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/shared_memory.hpp>
#include <takt/process.hpp>

#include "../system/components/sample.hpp"
#include "dds/domain.hpp"
namespace takt {

using Sample = ::samples::Count;

struct Quality {
  std::uint32_t depth = 1;
  bool safe = false;
  Nanoseconds deadline{};

  [[nodiscard]] std::uint32_t safe_room() const { return safe ? PortType<Sample>::info.max_size : 0; }
};

/// Returns a safe value that differs from every sample that the tests write.
inline Sample safe_sample() {
  Sample sample;
  sample.number(1'000'000);
  sample.same()[3] = -1;
  sample.few().push_back(7);
  return sample;
}
inline void give_safe(const channel::Link& link) {
  std::vector<std::byte> bytes(PortType<Sample>::info.max_size);
  bytes.resize(PortType<Sample>::encode(safe_sample(), bytes.data(), PortType<Sample>::info.max_size));
  link.give_safe(bytes);
}

/// A link with one writer and one reader. The reader can read each sample as soon as it is published. The
/// link holds objects if kObjects is true, and bytes otherwise.
template <bool kObjects>
class Link {
 public:
  /// True if a reader can read a sample as soon as it is published.
  static constexpr bool kAtOnce = true;
  static constexpr Nanoseconds kTolerance{0};  ///< by how much the age of a sample may be wrong
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
  /// Waits until every published sample can be read or is lost. For a Link, this is always so.
  void settle() const {}
  [[nodiscard]] channel::Link at_reader() const { return link(); }
  [[nodiscard]] std::uint64_t dropped() const { return link().block().overwritten.load(); }
  [[nodiscard]] std::uint64_t unfit() const { return link().block().unfit.load(); }

 private:
  [[nodiscard]] channel::Link link() const { return channel::Link{memory_.data()}; }
  os::SharedMemory memory_;
  void* values_ = nullptr;
};

using InHost = Link<true>;  // holds objects in the host's memory
using Ring = Link<false>;   // holds bytes in shared memory

/// A connection over DDS: a gateway in this process sends the samples to DDS, and a bridge process writes
/// them into the reader's link.
class BetweenDevices {
 public:
  static constexpr bool kAtOnce = false;
  static constexpr Nanoseconds kTolerance =
      std::chrono::milliseconds{100};  // tolerance for the conversion between two clocks
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
    setenv("TAKT_INTERFACE", "127.0.0.1", 1);  // the bridge process reads this variable
    out_ = gateway().add_outgoing(flow, link(from_)).value();
    bridge_ = node::Bridge::start({.device = "test",
                                   .domain = domain(),
                                   .peers = {},
                                   .wake_word = &wake_word_memory(),
                                   .place = made_ % 31 + 1,
                                   .flows = {{.flow = flow, .outgoing = false, .links = {&to_}}}})
                  .value();
    until([this] {
      return bridge_->opened() && gateway().health(out_).matched == 1 && bridge_->health(0).matched == 1;
    });
  }
  ~BetweenDevices() {
    gateway().remove(out_);
  }
  BetweenDevices(const BetweenDevices&) = delete;
  BetweenDevices& operator=(const BetweenDevices&) = delete;

  void connect(PortBase& port) {
    port.connect(link(port.direction() == PortDirection::out ? from_ : to_), nullptr);
  }
  void settle() {
    wake_word().rings.fetch_add(1);
    os::futex_wake(wake_word().rings, channel::kGatewayBit);
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
  static os::SharedMemory& wake_word_memory() {
    static os::SharedMemory memory =
        os::SharedMemory::create("takt-wake_word", sizeof(channel::WakeWord)).value();
    return memory;
  }
  static channel::WakeWord& wake_word() {
    return *reinterpret_cast<channel::WakeWord*>(wake_word_memory().data());
  }
  // One gateway for all tests, because a process may have only one DDS participant.
  static dds::Gateway& gateway() {
    static const auto made =
        dds::Gateway::create(
            dds::Participant::create(
                {.name = "ports_test", .domain = domain(), .discovery = {}, .interfaces = {"127.0.0.1"}})
                .value(),
            wake_word())
            .value();
    return *made;
  }
  template <class Condition>
  void until(Condition condition) {
    const Instant end = os::now() + long_enough();
    while (!condition()) {
      if (bridge_) bridge_->step(os::now());
      ASSERT_LT(os::now(), end) << "the connection does not settle";
      std::this_thread::sleep_for(std::chrono::milliseconds{1});
    }
  }

  static inline std::uint32_t made_ = 0;
  os::SharedMemory from_;
  os::SharedMemory to_;
  dds::Gateway::FlowId out_ = 0;
  std::unique_ptr<node::Bridge> bridge_;
};

/// A module with one output. write() sets the time of the module's run and writes a sample.
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
/// A module with one input. The tests set the time of its run in `context`.
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

using Ways = testing::Types<InHost, Ring, BetweenDevices>;

}  // namespace takt
