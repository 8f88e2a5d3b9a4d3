// Tests timing="let" (logical execution time) on virtual time. The results of the modules must depend neither
// on when each module runs within its periods, nor on how many modules run at the same time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include <takt/component.hpp>
#include <takt/process.hpp>

#include "../../system/components/sample.hpp"

namespace takt::logical_time_test {
namespace {

using ::samples::Count;

/// A connection between two ports, with the memory of its link.
struct Way {
  Way(OutPort<Count>& from, InPort<Count>& to, std::uint32_t depth, bool queue) {
    const channel::Link::Options options{
        .depth = depth, .payload = PortType<Count>::info.max_size, .is_queue = queue};
    memory.resize(channel::Link::layout(options).size() / sizeof(Line) + 1);
    auto* bytes = reinterpret_cast<std::byte*>(memory.data());
    channel::Link::format(bytes, options);
    from.connect(channel::Link{bytes}, nullptr);
    to.connect(channel::Link{bytes}, nullptr);
  }
  struct alignas(64) Line {
    std::byte bytes[64];
  };
  std::vector<Line> memory;
};

/// A module whose state depends on each sample that the module reads. The module writes a number that it
/// computes from its state.
struct Mixer {
  explicit Mixer(std::int64_t p) : period(p) { out.serve(context); }
  InPort<Count>& input() {
    ins.push_back(std::make_unique<InPort<Count>>("in" + std::to_string(ins.size())));
    ins.back()->serve(context);
    return *ins.back();
  }
  void mix(std::uint64_t number) { state = (state ^ number) * 0x9e3779b97f4a7c15U + 1; }
  void read() {
    for (const auto& in : ins) {
      while (in->read()) {
        EXPECT_TRUE(is_whole(in->value()));
        mix(in->value().number());
        mix(in->sequence());
        mix(static_cast<std::uint64_t>(in->age().count()));
      }
      mix(in->has_value() ? in->value().number() : 0);
    }
  }
  void write() {
    fill(sample, state % 1'000'000 + 1);
    out.write(sample);
  }

  std::int64_t period;
  std::uint64_t state = 1;
  PortContext context;
  Count sample;
  OutPort<Count> out{"out"};
  std::vector<std::unique_ptr<InPort<Count>>> ins;
};

constexpr std::int64_t kUnit = 1'000'000;
constexpr std::int64_t kStart = 1'000'000'000;

/// Simulates a random cell for 300 ms and returns the states of its modules. `cell` selects the modules and
/// their connections, and `times` selects when each module runs within its periods.
std::vector<std::uint64_t> run(std::uint64_t cell, std::uint64_t times, bool logical) {
  std::mt19937_64 draw{cell};
  std::vector<std::unique_ptr<Mixer>> modules;
  for (std::size_t n = 2 + draw() % 5; n > 0; --n)
    modules.push_back(std::make_unique<Mixer>(kUnit * static_cast<std::int64_t>(1 + draw() % 5)));
  std::vector<std::unique_ptr<Way>> ways;
  for (auto& from : modules) {
    for (auto& to : modules) {
      if (draw() % 2 == 0) continue;
      const auto ahead = static_cast<std::uint32_t>(to->period / from->period + 3);
      const bool queue = draw() % 3 == 0;
      ways.push_back(std::make_unique<Way>(from->out, to->input(), queue ? 8 + ahead : 1 + ahead, queue));
    }
  }

  struct Event {
    std::int64_t at;
    Mixer* module;
    std::int64_t release;
    bool reads;
  };
  std::vector<Event> events;
  std::mt19937_64 random{times};
  constexpr std::int64_t kEnd = kStart + 300 * kUnit;
  for (auto& module : modules) {
    for (std::int64_t release = kStart; release < kEnd; release += module->period) {
      const std::int64_t end = release + module->period;
      const auto anywhere = [&](std::int64_t from) {
        return from + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(end - from));
      };
      const std::int64_t read = anywhere(release);
      events.push_back({read, module.get(), release, true});
      events.push_back({anywhere(read), module.get(), release, false});
    }
  }
  std::stable_sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.at < b.at; });
  for (const Event& event : events) {
    Mixer& module = *event.module;
    module.context.start_ns = logical ? event.release : event.at;
    module.context.valid_ns = logical ? event.release + module.period : 0;
    event.reads ? module.read() : module.write();
  }
  std::vector<std::uint64_t> states;
  for (auto& module : modules) states.push_back(module->state);
  return states;
}

TEST(LogicalTime, MakesResultsIndependentOfRunTimes) {
  int others = 0;
  for (std::uint64_t cell = 1; cell <= 40; ++cell) {
    const auto states = run(cell, 1, true);
    for (std::uint64_t times = 2; times <= 6; ++times)
      ASSERT_EQ(run(cell, times, true), states) << "cell " << cell;
    others += run(cell, 1, false) != run(cell, 2, false) ? 1 : 0;
  }
  EXPECT_GT(others, 25) << "without logical time the results depend on run times";
}

TEST(LogicalTime, ShowsASampleOnlyAtTheEndOfTheWritersPeriod) {
  OutPort<Count> out{"out"};
  InPort<Count> in{"in"};
  PortContext writer;
  PortContext reader;
  out.serve(writer);
  in.serve(reader);
  const Way way{out, in, 5, false};
  Count sample;
  for (std::uint64_t n = 1; n <= 3; ++n) {
    writer.start_ns = static_cast<std::int64_t>(n) * 100;
    writer.valid_ns = writer.start_ns + 100;
    fill(sample, n);
    out.write(sample);
  }
  reader.start_ns = 199;
  EXPECT_FALSE(in.has_news());
  EXPECT_EQ(in.news_at(), 200);
  EXPECT_FALSE(in.read());
  reader.start_ns = 200;
  EXPECT_TRUE(in.has_news());
  EXPECT_TRUE(in.read());
  EXPECT_EQ(in.value().number(), 1U);
  EXPECT_EQ(in.age(), Nanoseconds{100});
  EXPECT_FALSE(in.read());
  EXPECT_EQ(in.value().number(), 1U) << "the value stays until the next one is valid";
  reader.start_ns = 450;
  EXPECT_TRUE(in.read());
  EXPECT_EQ(in.value().number(), 3U) << "the newest valid sample";
  EXPECT_FALSE(in.has_news());
  EXPECT_EQ(in.news_at(), channel::kNever);
}

}  // namespace
}  // namespace takt::logical_time_test
