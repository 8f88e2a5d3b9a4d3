// Tests that no real-time thread locks, allocates or waits while a running instance is swapped.
#include "real_time_path.hpp"

#include <mutex>

#include <folders.hpp>
#include <takt/channel/saved_state.hpp>
#include <takt/os/sealed_copy.hpp>
#include <takt/process.hpp>
#include "swap.hpp"

#include "../../system/components/sample.hpp"

namespace takt::host::real_time_swap_test {
namespace {

/// Swaps the component of module 1 for another real component. Each component counts its runs in its saved
/// state and publishes the count.
class RealTimeSwap : public RealTimePath {
 protected:
  static inline const std::string kFolder = build_path("tests/components/");

  void SetUp() override {
    if (TAKT_SANITIZED != 0) GTEST_SKIP() << "the sanitizer's own allocator and locks would be counted";
    const channel::Link::Options options{.depth = 256, .is_queue = true};
    memory.resize(channel::Link::layout(options).size() / sizeof(memory[0]));
    channel::Link::format(start(), options);
    runs = std::make_unique<ThreadModule>();
    runs->attach(&wake_word, &blocks[1]);
    runs->save_in(*saved);
    ASSERT_TRUE(runs->load(kFolder + "ticks.so", os::Library::Globals::shared, false).ok());
    values = runs->port("out")->make_values(channel::Link{start()}.buffers());
    connect(*runs);
    ASSERT_TRUE(runs->initialize({}).ok());
    ASSERT_TRUE(runs->start().ok());
    in.connect(channel::Link{start()}, values);
    in.serve(context);
    replaced = runs.get();
    RealTimePath::SetUp();
  }
  std::byte* start() { return memory[0].data(); }
  void connect(ThreadModule& module) { module.port("out")->connect(channel::Link{start()}, values); }

  Swapped swap(const std::string& file) {
    auto next = std::make_unique<ThreadModule>();
    next->attach(&wake_word, &blocks[1]);
    next->stand_by();
    const auto component = os::sealed_copy(kFolder + file);
    EXPECT_TRUE(component.ok());
    Swapped swapped = carry_out({.index = 1,
                                 .block = blocks[1],
                                 .before = *runs,
                                 .next = *next,
                                 .body = *next,
                                 .threads = *threads,
                                 .place = *saved,
                                 .activity = activity,
                                 .path = kFolder + file,
                                 .component = *component,
                                 .origin = os::Library::Origin::searched,
                                 .properties = {},
                                 .connect = [&]() -> Result<void> {
                                   connect(*next);
                                   return {};
                                 },
                                 .exclude = [] { return std::unique_lock<std::mutex>{}; },
                                 .handle_by = [](ThreadModule&) {},
                                 .ends = [this] { return end.load(); }});
    if (swapped.kept) runs.swap(next);
    return swapped;
  }

  struct alignas(64) Line : std::array<std::byte, 64> {};
  std::vector<Line> memory;
  void* values = nullptr;
  std::unique_ptr<channel::SavedState> saved = std::make_unique<channel::SavedState>();
  std::unique_ptr<ThreadModule> runs;
  channel::Activity activity{};
  PortContext context{.start_ns = 1};
  InPort<samples::Count> in{"in"};
  std::atomic<bool> end{false};
};

TEST_F(RealTimeSwap, NeverAllocatesOrLocksAndLosesNoSample) {
  std::uint64_t last = 0;
  std::uint64_t wrong = 0;
  bodies[2].on_run = [&](const Cycle&) {
    while (in.read()) {
      if (in.value().number() != last + 1 || !is_whole(in.value())) ++wrong;
      last = in.value().number();
    }
  };
  int kept = 0;
  int translated = 0;
  std::string failure;
  std::thread swapper{[&] {
    while (!end && failure.empty()) {
      // Alternates between two components, so that the swap sometimes copies and sometimes translates the
      // state.
      const bool other = kept % 3 == 0;
      const Swapped swapped = swap(other ? "ticks_more.so" : "ticks.so");
      if (swapped.kept) {
        ++kept;
        translated += other ? 1 : 0;
      } else if (!end) {
        failure = swapped.text;
      }
    }
  }};
  run(4000);
  end = true;
  swapper.join();
  EXPECT_EQ(failure, "");
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  for (const SystemCall& call : row_calls) EXPECT_EQ(call.number, SYS_futex) << "in cycle " << call.stamp;
  EXPECT_GT(kept, 20);
  EXPECT_GT(translated, 5);
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(last, 3000U);
  RecordProperty("kept", kept);
}

}  // namespace
}  // namespace takt::host::real_time_swap_test
