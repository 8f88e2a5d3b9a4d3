// Tests sporadic modules that events release: how often, when and in which order they run, and how a storm of
// events affects the rows.
#include <gtest/gtest.h>
#include <full_form.hpp>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>
#include <random>
#include <tuple>
#include <vector>

#include <takt/channel/link.hpp>

#include "fake_device.hpp"

namespace takt::executor::event_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;
constexpr auto kThread = model::ModuleType::thread;
constexpr auto kProcess = model::ModuleType::process;

const char* hold(bool* ready) {
  *ready = true;
  return nullptr;
}

model::Module event_module(Nanoseconds deadline, Nanoseconds interarrival, model::Dispatch dispatch) {
  model::Module module = sporadic(kThread, deadline);
  if (interarrival != Nanoseconds{0}) module.interarrival = interarrival;
  module.dispatch = dispatch;
  return module;
}

TEST(Interarrival, IsTheMinimumTimeBetweenTwoReleasesByRows) {
  FakeDevice device{
      {thread(milliseconds{1}), event_module(milliseconds{5}, microseconds{2500}, model::Dispatch::row)}};
  std::vector<Instant> releases;
  device.bodies[1].on_condition = hold;
  device.bodies[1].on_run = [&](const Cycle& cycle) {
    releases.push_back(cycle.time);
    return nullptr;
  };
  device.join();
  for (int i = 0; i < 10; ++i) {
    device.cycle();
    while (device.executor->run_sporadic()) {
    }
  }
  // Rows are due every millisecond from 0 ms on. After a release at 0 ms, the row at 3 ms is the first row
  // that is at least 2.5 ms later.
  ASSERT_EQ(releases.size(), 4U);
  for (std::size_t i = 1; i < releases.size(); ++i) EXPECT_EQ(releases[i] - releases[i - 1], milliseconds{3});
  EXPECT_EQ(device.bodies[1].asked, 4) << "the condition is not checked when no release is allowed";
}

TEST(Interarrival, AlsoLimitsTheReleasesOfPrograms) {
  model::Module program = sporadic(kProcess, milliseconds{5});
  program.interarrival = milliseconds{4};
  FakeDevice device{{thread(milliseconds{1}), program}};
  device.join();
  for (int i = 0; i < 12; ++i) {
    device.cycle();
    device.slots[1].done.store(device.slots[1].released.load());  // the program finishes its body at once
  }
  EXPECT_EQ(device.blocks[1].cycles.load(), 3U);
}

TEST(ImmediateModule, RunsBetweenRowsWhenItHasAnUnreadEvent) {
  FakeDevice device{{thread(milliseconds{1}), event_module(milliseconds{5}, {}, model::Dispatch::immediate)}};
  bool news = false;
  Cycle seen;
  device.bodies[1].on_news = [&] { return news; };
  device.bodies[1].on_condition = hold;
  device.bodies[1].on_run = [&](const Cycle& cycle) {
    seen = cycle;
    news = false;
    return nullptr;
  };
  device.join();
  device.cycle();
  EXPECT_FALSE(device.executor->run_sporadic()) << "it has no unread event";
  device.clock.time += microseconds{300};
  news = true;
  EXPECT_TRUE(device.executor->run_sporadic());
  EXPECT_EQ(seen.time, device.clock.time) << "released when the event was seen, not at a row";
  EXPECT_FALSE(device.executor->run_sporadic());
  EXPECT_EQ(device.blocks[1].cycles.load(), 1U);
}

TEST(ImmediateModule, IsWokenButNotRunByARow) {
  FakeDevice device{{thread(milliseconds{1}), event_module(milliseconds{5}, {}, model::Dispatch::immediate)}};
  bool news = false;
  device.bodies[1].on_news = [&] { return news; };
  device.join();
  EXPECT_EQ(device.cycle(), 0U);
  news = true;
  EXPECT_EQ(device.cycle(), channel::kSporadicBit);
  EXPECT_EQ(device.bodies[1].asked, 0);
}

TEST(ImmediateModule, IsWokenByTheFirstRowAfterItsInterarrivalTime) {
  FakeDevice device{{thread(milliseconds{1}),
                     event_module(milliseconds{5}, microseconds{1500}, model::Dispatch::immediate)}};
  device.bodies[1].on_news = [] { return true; };
  device.bodies[1].on_condition = hold;
  device.join();
  device.cycle();
  EXPECT_TRUE(device.executor->run_sporadic());   // the module runs at 0 ms
  EXPECT_FALSE(device.executor->run_sporadic());  // the module does not run a second time at 0 ms
  EXPECT_EQ(device.cycle(), 0U) << "at 1 ms it may not run yet";
  EXPECT_FALSE(device.executor->run_sporadic());
  EXPECT_EQ(device.cycle(), channel::kSporadicBit);
  EXPECT_TRUE(device.executor->run_sporadic());
}

TEST(ImmediateModule, DoesNotRunWhileRemovedFromTheTables) {
  FakeDevice device{{thread(milliseconds{1}), event_module(milliseconds{5}, {}, model::Dispatch::immediate)}};
  device.bodies[1].on_news = [] { return true; };
  device.bodies[1].on_condition = hold;
  device.blocks[1].in_tables.store(0);
  device.join();
  device.cycle();
  EXPECT_FALSE(device.executor->run_sporadic());
  EXPECT_EQ(device.bodies[1].asked, 0);
}

TEST(ImmediateModule, RunsBeforeAModuleWithALaterDeadline) {
  FakeDevice device{{thread(milliseconds{1}), event_module(milliseconds{50}, {}, model::Dispatch::row),
                     event_module(milliseconds{5}, {}, model::Dispatch::immediate)}};
  std::string ran;
  bool news = true;
  device.bodies[1].on_condition = hold;
  device.bodies[2].on_condition = hold;
  device.bodies[2].on_news = [&] { return news; };
  device.bodies[1].on_run = [&](const Cycle&) {
    ran += "row ";
    return nullptr;
  };
  device.bodies[2].on_run = [&](const Cycle&) {
    ran += "event ";
    news = false;
    return nullptr;
  };
  device.join();
  device.cycle();
  while (device.executor->run_sporadic()) {
  }
  EXPECT_EQ(ran, "event row ");
}

TEST(Deadline, RaisesAnErrorWhenMissedOnlyIfTheDescriptorSaysSo) {
  for (const model::Miss miss : {model::Miss::count, model::Miss::error}) {
    model::Module late = sporadic(kThread, milliseconds{2});
    late.miss = miss;
    FakeDevice device{{thread(milliseconds{1}), late}};
    device.bodies[1].on_condition = hold;
    device.bodies[1].on_run = [&](const Cycle&) {
      device.clock.time += microseconds{3250};
      return nullptr;
    };
    device.join();
    device.cycle();
    EXPECT_TRUE(device.executor->run_sporadic());
    EXPECT_EQ(device.blocks[1].overruns.load(), 1U);
    const bool error = miss == model::Miss::error;
    EXPECT_EQ(device.blocks[1].error.load(),
              static_cast<std::uint32_t>(error ? ErrorType::deadline : ErrorType::none));
    EXPECT_EQ(device.blocks[1].in_tables.load(), error ? 0U : 1U);
    if (error) {
      EXPECT_EQ(device.blocks[1].error_text.view(), "run() ended 1250 us after its deadline");
    }
  }
}

TEST(Deadline, IsMetIfTheRunEndsExactlyOnTime) {
  model::Module punctual = sporadic(kThread, milliseconds{2});
  punctual.miss = model::Miss::error;
  FakeDevice device{{thread(milliseconds{1}), punctual}};
  device.bodies[1].on_condition = hold;
  device.bodies[1].on_run = [&](const Cycle&) {
    device.clock.time += milliseconds{2};
    return nullptr;
  };
  device.join();
  device.cycle();
  EXPECT_TRUE(device.executor->run_sporadic());
  EXPECT_EQ(device.blocks[1].error.load(), 0U);
  EXPECT_EQ(device.blocks[1].overruns.load(), 0U);
}

/// Memory that contains a link and is aligned as a link requires.
class LinkMemory {
 public:
  explicit LinkMemory(const channel::Link::Options& options)
      : memory_(static_cast<std::byte*>(std::aligned_alloc(64, channel::Link::layout(options).size()))) {
    channel::Link::format(memory_.get(), options);
  }
  [[nodiscard]] channel::Link link() const { return channel::Link{memory_.get()}; }

 private:
  struct Free {
    void operator()(std::byte* memory) const { std::free(memory); }
  };
  std::unique_ptr<std::byte, Free> memory_;
};

struct Storm {
  model::Dispatch dispatch;
  Nanoseconds interarrival;
};

/// A storm of 20,000 events per second, which arrive at random times at a module that takes 50 us for each
/// event. Rows preempt the module: the test runs each row that falls due during run() inside that run().
class StormOfEvents : public testing::TestWithParam<Storm> {};

TEST_P(StormOfEvents, NeverDelaysARow) {
  constexpr std::uint32_t kDepth = 16;
  constexpr auto kPeriod = milliseconds{1};
  constexpr auto kWork = microseconds{50};
  const auto length = seconds{kSanitized && !full_form() ? 6 : 60};
  const auto all_rows = static_cast<std::uint64_t>(length / kPeriod);
  FakeDevice device{
      {thread(kPeriod), event_module(milliseconds{20}, GetParam().interarrival, GetParam().dispatch)}};
  LinkMemory memory{{.depth = kDepth, .payload = 8, .is_queue = true}};
  channel::LinkWriter writer{memory.link()};
  channel::LinkReader reader{memory.link()};

  std::uint64_t rows = 0;
  std::uint64_t taken = 0;
  Instant last_release{};
  bool first = true;
  device.bodies[0].on_run = [&](const Cycle& cycle) {
    EXPECT_EQ(cycle.number, rows);
    EXPECT_EQ(cycle.time, device.t0 + kPeriod * static_cast<std::int64_t>(rows));
    EXPECT_EQ(cycle.start, cycle.time) << "the row starts on time";
    ++rows;
    return nullptr;
  };
  device.bodies[1].on_news = [&] { return reader.has_news(); };
  device.bodies[1].on_condition = [&](bool* ready) -> const char* {
    *ready = reader.has_news();
    return nullptr;
  };
  device.bodies[1].on_run = [&](const Cycle& cycle) {
    if (!first) {
      EXPECT_GE(cycle.time - last_release, GetParam().interarrival);
    }
    first = false;
    last_release = cycle.time;
    EXPECT_TRUE(reader.take());
    ++taken;
    const Instant end = device.clock.time + kWork;
    while (device.executor->next_release() <= end) {
      device.clock.time = device.executor->next_release();
      device.executor->run_cycle(device.clock.time);
    }
    device.clock.time = end;
    return nullptr;
  };
  device.join();

  std::mt19937_64 random{7};
  std::exponential_distribution<double> gap{20'000.0 / 1e9};
  const auto next_gap = [&] { return Nanoseconds{1 + static_cast<std::int64_t>(gap(random))}; };
  const Instant end = device.t0 + length;
  Instant event = device.t0 + next_gap();
  std::uint64_t written = 0;
  const auto publish_due = [&] {
    for (; event <= device.clock.time; event += next_gap(), ++written) writer.publish(8, to_ns(event));
  };
  while (device.executor->next_release() < end) {
    if (event < device.executor->next_release()) {
      device.clock.time = std::max(device.clock.time, event);
    } else {
      device.cycle();
    }
    publish_due();
    while (device.executor->run_sporadic()) publish_due();
  }

  EXPECT_GE(rows, all_rows);
  EXPECT_LE(rows, all_rows + 1) << "the last run() may have reached into the next row";
  EXPECT_EQ(device.block->missed.load(), 0U);
  EXPECT_EQ(device.block->late.load(), 0U);
  EXPECT_NEAR(static_cast<double>(written) / static_cast<double>(length.count()), 20'000, 83);
  // The module has read each event, or the full queue has dropped and counted the event, or the event is in
  // the queue.
  const std::uint64_t dropped = memory.link().block().overwritten.load();
  std::uint64_t waiting = 0;
  while (reader.take()) ++waiting;
  EXPECT_EQ(written, taken + dropped + waiting);
  EXPECT_LE(waiting, kDepth);
  const auto most =
      static_cast<std::uint64_t>(length / std::max(GetParam().interarrival, Nanoseconds{kWork})) + 1;
  EXPECT_LE(taken, most);
  EXPECT_GT(taken, 0U);
  if (GetParam().interarrival > Nanoseconds{kWork} && GetParam().dispatch == model::Dispatch::row) {
    EXPECT_EQ(taken, all_rows - 1) << "one per row, except the first, before which there was no event";
  }
}

INSTANTIATE_TEST_SUITE_P(Dispatch, StormOfEvents,
                         testing::Values(Storm{model::Dispatch::row, microseconds{500}},
                                         Storm{model::Dispatch::immediate, microseconds{500}},
                                         Storm{model::Dispatch::immediate, microseconds{0}},
                                         Storm{model::Dispatch::row, microseconds{0}},
                                         Storm{model::Dispatch::immediate, milliseconds{3}}),
                         [](const auto& each) {
                           return std::string{model::to_text(each.param.dispatch)} + "_" +
                                  std::to_string(each.param.interarrival.count() / 1000) + "_us";
                         });

/// Runs random sets of modules and checks the order of their runs. Of the released modules, the module with
/// the earliest absolute deadline must run first. If deadlines are equal, the priority decides.
TEST(SporadicOrder, IsEarliestDeadlineFirstForRandomSetsOfModules) {
  std::mt19937 random{11};
  for (int set = 0; set < 300; ++set) {
    const std::size_t count = 2 + random() % 6;
    std::vector<model::Module> modules{thread(milliseconds{1})};
    for (std::size_t i = 0; i < count; ++i) {
      modules.push_back(event_module(milliseconds{2 + static_cast<int>(random() % 5)}, {},
                                     random() % 2 == 0 ? model::Dispatch::row : model::Dispatch::immediate));
      modules.back().priority = static_cast<int>(random() % 4);
    }
    FakeDevice device{modules};
    std::vector<std::size_t> ran;
    std::vector<bool> news(count + 1, false);
    for (std::size_t i = 1; i <= count; ++i) {
      news[i] = random() % 3 != 0;
      device.bodies[i].on_news = [&news, i] { return news[i]; };
      device.bodies[i].on_condition = [&news, i](bool* ready) -> const char* {
        *ready = news[i];
        return nullptr;
      };
      device.bodies[i].on_run = [&ran, &news, i](const Cycle&) {
        ran.push_back(i);
        news[i] = false;
        return nullptr;
      };
    }
    const std::vector<bool> wanted_news = news;
    device.join();
    device.cycle();
    while (device.executor->run_sporadic()) {
    }
    std::vector<std::size_t> wanted;
    for (std::size_t i = 1; i <= count; ++i) {
      if (wanted_news[i]) wanted.push_back(i);
    }
    // All modules were released at the same instant, because the virtual clock does not advance. So the
    // module with the shortest relative deadline has the earliest absolute deadline.
    std::stable_sort(wanted.begin(), wanted.end(), [&](std::size_t a, std::size_t b) {
      return std::pair{*modules[a].deadline, modules[a].priority} <
             std::pair{*modules[b].deadline, modules[b].priority};
    });
    EXPECT_EQ(ran, wanted) << "set " << set;
  }
}

/// A simple model of scheduling by earliest deadline first. The model computes when each module is released,
/// and which module runs next.
struct Rule {
  struct Each {
    model::Module module;
    int events = 0;
    std::optional<Instant> released{};
    Instant not_before{};

    void release(Instant at) {
      released = at;
      not_before = at + module.interarrival.value_or(Nanoseconds{0});
    }
    [[nodiscard]] bool may_be_released(Instant at) const {
      return !released && events > 0 && at >= not_before;
    }
  };
  std::vector<Each> all;  // indexed like the modules of the device

  void row(Instant at) {
    for (Each& each : all) {
      if (each.module.dispatch == model::Dispatch::row && each.may_be_released(at)) each.release(at);
    }
  }
  std::optional<std::size_t> next(Instant now) {
    std::optional<std::size_t> first;
    const auto rank = [this](std::size_t i) {
      return std::tuple{*all[i].released + *all[i].module.deadline, all[i].module.priority, i};
    };
    for (std::size_t i = 0; i < all.size(); ++i) {
      Each& each = all[i];
      if (each.module.operation != model::Operation::sporadic) continue;
      if (each.module.dispatch == model::Dispatch::immediate && each.may_be_released(now)) each.release(now);
      if (each.released && (!first || rank(i) < rank(*first))) first = i;
    }
    return first;
  }
};

// Compares the executor with Rule for random events, bodies of random length, and rows that fall due during a
// body.
TEST(SporadicOrder, IsEarliestDeadlineFirstForRandomEvents) {
  constexpr auto kPeriod = milliseconds{1};
  std::mt19937 random{23};
  const auto up_to = [&random](int most) { return static_cast<int>(random() % static_cast<unsigned>(most)); };
  std::uint64_t runs = 0;
  std::uint64_t overtaken = 0;
  for (int set = 0; set < 60; ++set) {
    std::vector<model::Module> modules{thread(kPeriod)};
    const int count = 2 + up_to(5);
    for (int i = 0; i < count; ++i) {
      modules.push_back(event_module(microseconds{500 * (1 + up_to(12))}, microseconds{up_to(3) * 700},
                                     up_to(2) == 0 ? model::Dispatch::row : model::Dispatch::immediate));
      modules.back().priority = up_to(3);
    }
    Rule rule;
    for (const model::Module& module : modules) rule.all.push_back({.module = module});
    FakeDevice device{modules};
    struct Arrival {
      Instant at;
      std::size_t module;
    };
    std::vector<Arrival> arrivals;
    const Instant begin = device.clock.time;
    const Instant end = begin + milliseconds{200};
    for (Instant at = begin; at < end; at += microseconds{up_to(700)})
      arrivals.push_back({at, 1 + static_cast<std::size_t>(up_to(count))});
    std::size_t arrived = 0;

    // Advances time to `then`. Delivers the events that arrive until then, and runs the rows that fall due.
    const auto pass_to = [&](Instant then) {
      while (true) {
        const Instant row = device.executor->next_release();
        const bool event = arrived < arrivals.size() && arrivals[arrived].at <= std::min(row, then);
        if (event) {
          device.clock.time = std::max(device.clock.time, arrivals[arrived].at);
          ++rule.all[arrivals[arrived++].module].events;
        } else if (row <= then) {
          device.clock.time = std::max(device.clock.time, row);
          device.executor->run_cycle(device.clock.time);
          rule.row(row);
        } else {
          break;
        }
      }
      device.clock.time = std::max(device.clock.time, then);
    };
    std::optional<std::size_t> ran;
    for (std::size_t i = 1; i < modules.size(); ++i) {
      device.bodies[i].on_news = [&rule, i] { return rule.all[i].events > 0; };
      device.bodies[i].on_condition = [&rule, i](bool* ready) -> const char* {
        *ready = rule.all[i].events > 0;
        return nullptr;
      };
      device.bodies[i].on_run = [&, i](const Cycle& cycle) -> const char* {
        ran = i;
        EXPECT_EQ(cycle.time, rule.all[i].released) << "set " << set << " module " << i;
        --rule.all[i].events;
        pass_to(device.clock.time + microseconds{up_to(400)});
        return nullptr;
      };
    }
    device.join();
    while (device.clock.time < end) {
      pass_to(std::min(device.executor->next_release(),
                       arrived < arrivals.size() ? arrivals[arrived].at : Instant::max()));
      while (true) {
        const auto wanted = rule.next(device.clock.time);
        ran.reset();
        ASSERT_EQ(device.executor->run_sporadic(), wanted.has_value()) << "set " << set;
        ASSERT_EQ(ran, wanted) << "set " << set;
        if (!wanted) break;
        for (const auto& each : rule.all) {
          if (each.released && *each.released < *rule.all[*wanted].released) ++overtaken;
        }
        rule.all[*wanted].released.reset();
        ++runs;
      }
    }
  }
  EXPECT_GT(runs, 5'000U);
  EXPECT_GT(overtaken, 500U) << "deadlines must have changed the order often";
}

}  // namespace
}  // namespace takt::executor::event_test
