// Checks that real-time threads keep Takt's promise: they take no lock, allocate no memory, and make no
// system call except their sleep and at most one wake-up through the wake word per cycle.
#include "real_time_path.hpp"

#include <takt/channel/saved_state.hpp>
#include <takt/component.hpp>
#include <takt/component/live_properties.hpp>
#include <takt/process.hpp>

#include "../../system/components/sample.hpp"
#include "connected_service.hpp"

namespace takt::host::real_time_path_test {
namespace {

TEST_F(RealTimePath, MakesNoSystemCallExceptSleepAndOneWakeUpPerCycle) {
  run(4000);
  ASSERT_FALSE(row_calls.empty());
  std::map<std::uint64_t, int> sleeps;  // number of sleeps in each cycle
  std::map<std::uint64_t, int> rings;
  for (const SystemCall& call : row_calls) {
    if (is_futex(call, FUTEX_WAIT_BITSET, threads.get(), sizeof *threads)) {
      ++sleeps[call.stamp];
    } else if (is_futex(call, FUTEX_WAKE_BITSET, &wake_word, sizeof wake_word)) {
      ++rings[call.stamp];
    } else {
      ADD_FAILURE() << "system call " << call.number << " in cycle " << call.stamp;
    }
  }
  for (const auto& [cycle, n] : sleeps) EXPECT_EQ(n, 1) << "sleeps before cycle " << cycle;
  for (const auto& [cycle, n] : rings) EXPECT_EQ(n, 1) << "wake-ups after cycle " << cycle;
  EXPECT_GT(rings.size(), 1000U) << "the program should have slept";

  ASSERT_FALSE(sporadic_calls.empty());
  for (const SystemCall& call : sporadic_calls) {
    EXPECT_TRUE(is_futex(call, FUTEX_WAIT_BITSET, &wake_word, sizeof wake_word))
        << "system call " << call.number;
    EXPECT_EQ(call.arguments[5], channel::kSporadicBit);
  }
  EXPECT_GT(blocks[kSporadic].cycles.load(), 500U);
  EXPECT_GT(blocks[kProgram].cycles.load(), 1000U);
  EXPECT_GT(record.copy(0).written, 3 * 4000U) << "one entry per row, and one per run";
  EXPECT_GT(record.copy(1).written, 500U);
  RecordProperty("row_calls", static_cast<int>(row_calls.size()));
}

TEST_F(RealTimePath, NeverAllocatesOrLocks) {
  run(2000);
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  EXPECT_GT(blocks[kSporadic].cycles.load(), 200U);
}

// The test sets strings of many lengths, so that each change must free and allocate memory somewhere.
TEST_F(RealTimePath, AppliesPropertiesWithoutAllocatingOrLocking) {
  struct Named : Component {
    Property<std::string> label{*this, "label", "none"};
    Property<double> gain{*this, "gain", 0.0};
    void run(const Cycle&) noexcept override {}
  } component;
  LiveProperties live;
  live.serve(component.properties(), "component Named");
  std::atomic<std::uint64_t> changes{0};
  double last = 0;
  bodies[1].on_run = [&](const Cycle&) {
    live.take_over();
    if (component.gain == last) return;
    last = component.gain;
    if (component.label.value().size() == static_cast<std::size_t>(last) % 100) ++changes;
  };
  std::atomic<bool> end{false};
  std::thread setter{[&] {
    for (int n = 1; !end; ++n) {
      const std::string label(static_cast<std::size_t>(n % 100), 'x');
      EXPECT_TRUE(live.set({{"gain", std::to_string(n)}, {"label", label}}).ok());
      std::this_thread::sleep_for(microseconds{300});
    }
  }};
  run(2000);
  end = true;
  setter.join();
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  for (const SystemCall& call : row_calls) EXPECT_EQ(call.number, SYS_futex);
  EXPECT_GT(changes.load(), 500U);
}

/// An output, an input, and the link that connects them.
struct Connected {
  Connected(bool as_objects, std::uint32_t wake_bits, bool has_safe_value = false,
            bool can_be_forced = false) {
    const std::uint32_t most = PortType<samples::Count>::info.max_size;
    const channel::Link::Options options{.depth = can_be_forced ? 1U : 4U,
                                         .payload = as_objects ? 0 : most,
                                         .is_queue = !can_be_forced,
                                         .wake_bits = wake_bits,
                                         .safe = has_safe_value ? most : 0,
                                         .force = can_be_forced ? most : 0};
    memory.resize(channel::Link::layout(options).size() / sizeof(Line));
    auto* start = reinterpret_cast<std::byte*>(memory.data());
    channel::Link::format(start, options);
    link = channel::Link{start};
    if (has_safe_value) {
      samples::Count count;
      fill(count, kSafe);
      std::vector<std::byte> bytes(most);
      bytes.resize(PortType<samples::Count>::encode(count, bytes.data(), most));
      link.give_safe(bytes);
    }
    void* values = as_objects ? out.make_values(link.buffers()) : nullptr;
    out.connect(link, values);
    in.connect(link, values);
  }
  struct alignas(64) Line {
    std::array<std::byte, 64> bytes;
  };
  static constexpr std::uint64_t kSafe = 1'000'000'000;
  std::vector<Line> memory;
  channel::Link link;
  OutPort<samples::Count> out{"out"};
  InPort<samples::Count> in{"in"};
};

TEST_F(RealTimePath, MovesSamplesWithoutAllocatingOrLockingAndWakesOncePerCycle) {
  Connected objects{true, 0};
  Connected bytes{false, channel::kSporadicBit};
  PortContext context{.start_ns = 1, .wake_word = &wake_word, .flight = flight.data(), .module = 1};
  for (Connected* each : {&objects, &bytes}) {
    each->out.serve(context);
    each->in.serve(context);
  }
  samples::Count count;
  count.few().reserve(4);
  std::uint64_t wrong = 0;
  std::uint64_t read = 0;
  bodies[1].on_run = [&](const Cycle& cycle) {
    for (int i = 0; i < 3; ++i) {
      fill(count, cycle.number + 1);
      objects.out.write(count);
      bytes.out.write(count);
    }
  };
  bodies[2].on_run = [&](const Cycle&) {
    for (Connected* each : {&objects, &bytes}) {
      while (each->in.read()) {
        ++read;
        if (!is_whole(each->in.value())) ++wrong;
      }
    }
  };
  run(2000);
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(read, 2000U);
  std::map<std::uint64_t, int> rings;
  for (const SystemCall& call : row_calls) {
    EXPECT_EQ(call.number, SYS_futex) << "in cycle " << call.stamp;
    if (is_futex(call, FUTEX_WAKE_BITSET, &wake_word, sizeof wake_word)) ++rings[call.stamp];
  }
  for (const auto& [cycle, n] : rings) EXPECT_EQ(n, 1) << "wake-ups after cycle " << cycle;
}

// A module writes samples, while the node repeatedly switches the reader to the safe value and back.
TEST_F(RealTimePath, SwitchesToSafeValuesWithoutAllocatingOrLocking) {
  Connected objects{true, 0, true};
  Connected bytes{false, 0, true};
  PortContext context{.start_ns = 1, .wake_word = &wake_word, .flight = flight.data(), .module = 1};
  for (Connected* each : {&objects, &bytes}) {
    each->out.serve(context);
    each->in.serve(context);
  }
  samples::Count count;
  count.few().reserve(4);
  std::uint64_t wrong = 0;
  std::uint64_t read = 0;
  std::uint64_t safe = 0;
  bodies[1].on_run = [&](const Cycle& cycle) {
    fill(count, cycle.number + 1);
    objects.out.write(count);
    bytes.out.write(count);
  };
  bodies[2].on_run = [&](const Cycle&) {
    for (Connected* each : {&objects, &bytes}) {
      while (each->in.read()) {
        ++(each->in.is_safe() ? safe : read);
        if (!is_whole(each->in.value())) ++wrong;
        if (each->in.is_safe() != (each->in.value().number() == Connected::kSafe)) ++wrong;
      }
    }
  };
  std::atomic<bool> end{false};
  std::thread node{[&] {
    while (!end) {
      for (Connected* each : {&objects, &bytes}) each->link.trust();
      std::this_thread::sleep_for(milliseconds{3});
      for (Connected* each : {&objects, &bytes}) each->link.withhold();
      std::this_thread::sleep_for(milliseconds{3});
    }
  }};
  run(2000);
  end = true;
  node.join();
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  for (const SystemCall& call : row_calls) EXPECT_EQ(call.number, SYS_futex) << "in cycle " << call.stamp;
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(read, 200U);
  EXPECT_GT(safe, 50U);
}

// The lists of the samples and of the forced value have different lengths.
TEST_F(RealTimePath, SwitchesToForcedValuesWithoutAllocatingOrLocking) {
  Connected objects{true, 0, false, true};
  Connected bytes{false, 0, false, true};
  PortContext context{.start_ns = 1, .wake_word = &wake_word, .flight = flight.data(), .module = 1};
  for (Connected* each : {&objects, &bytes}) {
    each->out.serve(context);
    each->in.serve(context);
  }
  constexpr std::uint64_t kForced = 1'000'000'004;
  const std::uint32_t most = PortType<samples::Count>::info.max_size;
  samples::Count count;
  fill(count, kForced);
  std::vector<std::byte> value(most);
  value.resize(PortType<samples::Count>::encode(count, value.data(), most));
  std::uint64_t wrong = 0;
  std::uint64_t read = 0;
  std::uint64_t forced = 0;
  bodies[1].on_run = [&](const Cycle& cycle) {
    context.start_ns = static_cast<std::int64_t>(cycle.number) + 2;
    fill(count, cycle.number + 1);
    objects.out.write(count);
    bytes.out.write(count);
  };
  bodies[2].on_run = [&](const Cycle&) {
    for (Connected* each : {&objects, &bytes}) {
      while (each->in.read()) {
        ++(each->in.value().number() == kForced ? forced : read);
        if (!is_whole(each->in.value())) ++wrong;
      }
    }
  };
  std::atomic<bool> end{false};
  std::thread node{[&] {
    for (std::uint32_t number = 1; !end; ++number) {
      for (Connected* each : {&objects, &bytes}) {
        while (!each->link.force(number, value, channel::kNever))
          std::this_thread::sleep_for(milliseconds{1});
      }
      std::this_thread::sleep_for(milliseconds{3});
      for (Connected* each : {&objects, &bytes}) each->link.end_force();
      std::this_thread::sleep_for(milliseconds{3});
    }
  }};
  run(2000);
  end = true;
  node.join();
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  for (const SystemCall& call : row_calls) EXPECT_EQ(call.number, SYS_futex) << "in cycle " << call.stamp;
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(read, 200U);
  EXPECT_GT(forced, 200U);
}

TEST_F(RealTimePath, SavesStateWithoutAllocatingOrLocking) {
  const auto place = std::make_unique<channel::SavedState>();
  std::array<std::uint64_t, channel::kMostSaved / sizeof(std::uint64_t)> kept{};
  bodies[1].on_run = [&](const Cycle& cycle) {
    kept.fill(cycle.number);
    place->save(kept.data(), sizeof kept, 1, to_ns(cycle.start));
  };
  run(2000);
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  for (const SystemCall& call : row_calls) EXPECT_EQ(call.number, SYS_futex) << "in cycle " << call.stamp;
  ASSERT_NE(place->saved(), nullptr);
  EXPECT_GT(place->saved()->number, 1000U);
}

TEST_F(RealTimePath, ServesCallsWithoutAllocatingOrLockingAndWakesOncePerCycle) {
  struct Answers : Plain {
    Service<samples::Count, samples::Count> answer{*this, "answer"};
  } server;
  Asking<samples::Count> objects;
  Asking<samples::Count> bytes;
  const ConnectedService first{objects, server, "answer", true};
  const ConnectedService second{bytes, server, "answer", false, channel::kSporadicBit};
  PortContext context{.start_ns = 1, .wake_word = &wake_word};
  for (Component* each : std::initializer_list<Component*>{&objects, &bytes, &server})
    serve_all(*each, context);
  samples::Count count;
  samples::Count answer;
  count.few().reserve(4);
  answer.few().reserve(4);
  std::array<std::uint64_t, 6> counts{};
  std::uint64_t wrong = 0;
  std::uint64_t last = 0;
  bodies[1].on_run = [&](const Cycle& cycle) {
    context.start_ns = to_ns(cycle.start);
    for (auto* each : {&objects, &bytes}) {
      const CallStatus status = each->ask.poll();
      ++counts[static_cast<std::size_t>(status)];
      if (status == CallStatus::pending) continue;
      if (status == CallStatus::replied &&
          (!is_whole(each->ask.reply()) || each->ask.reply().number() % 2 != 0))
        ++wrong;
      fill(count, ++last);
      each->ask.call(count, milliseconds{20});
    }
  };
  bodies[2].on_run = [&](const Cycle&) {
    while (server.answer.take()) {
      if (server.answer.request().number() % 7 == 0) {
        server.answer.refuse("a multiple of 7");
      } else if (server.answer.request().number() % 13 != 0) {
        fill(answer, 2 * server.answer.request().number());
        server.answer.reply(answer);
      }
    }
  };
  run(2000);
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(counts[static_cast<std::size_t>(CallStatus::replied)], 100U);
  EXPECT_GT(counts[static_cast<std::size_t>(CallStatus::refused)], 10U);
  EXPECT_GT(counts[static_cast<std::size_t>(CallStatus::timed_out)], 3U);
  std::map<std::uint64_t, int> rings;
  for (const SystemCall& call : row_calls) {
    EXPECT_EQ(call.number, SYS_futex) << "in cycle " << call.stamp;
    if (is_futex(call, FUTEX_WAKE_BITSET, &wake_word, sizeof wake_word)) ++rings[call.stamp];
  }
  for (const auto& [cycle, n] : rings) EXPECT_EQ(n, 1) << "wake-ups after cycle " << cycle;
}

}  // namespace
}  // namespace takt::host::real_time_path_test
