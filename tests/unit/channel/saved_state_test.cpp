#include <takt/channel/saved_state.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <thread>

namespace takt::channel::saved_state_test {
namespace {

using Words = std::array<std::uint64_t, 64>;

class SavedModuleState : public testing::Test {
 protected:
  static Words words(std::uint64_t value) {
    Words all;
    all.fill(value);
    return all;
  }
  void save(std::uint64_t value, std::uint32_t version = 1) {
    const Words all = words(value);
    state->save(all.data(), sizeof all, version, static_cast<std::int64_t>(value));
  }
  static Words read(const SavedState::Copy& copy) {
    Words all;
    std::memcpy(all.data(), copy.bytes.data(), sizeof all);
    return all;
  }
  std::unique_ptr<SavedState> state = std::make_unique<SavedState>();
};

TEST_F(SavedModuleState, IsEmptyAtFirst) {
  EXPECT_EQ(state->saved(), nullptr);
  EXPECT_FALSE(state->copy().has_value());
}

TEST_F(SavedModuleState, ReturnsTheStateThatWasSavedLast) {
  for (std::uint64_t value = 1; value <= 5; ++value) {
    save(value, 7);
    ASSERT_NE(state->saved(), nullptr);
    EXPECT_EQ(read(*state->saved()), words(value));
    EXPECT_EQ(state->saved()->version, 7U);
    EXPECT_EQ(state->saved()->size, sizeof(Words));
    EXPECT_EQ(state->saved()->saved_ns, static_cast<std::int64_t>(value));
    EXPECT_EQ(state->copy()->number, value);
  }
}

TEST_F(SavedModuleState, HoldsAStateOfTheMaximumSize) {
  std::array<std::byte, kMostSaved> all;
  all.fill(std::byte{9});
  state->save(all.data(), kMostSaved, 1, 0);
  EXPECT_EQ(state->saved()->bytes, all);
}

// A process that dies while it saves leaves one of the two copies partly written. This copy is not published
// yet, so a reader gets the other copy.
TEST_F(SavedModuleState, KeepsThePreviousStateIfTheProcessDiesWhileSaving) {
  save(1);
  save(2);
  SavedState::Copy& next = state->copies[3 % 2];
  next.number = 3;
  next.size = kMostSaved;
  next.bytes.fill(std::byte{0xee});
  ASSERT_NE(state->saved(), nullptr);
  EXPECT_EQ(read(*state->saved()), words(2));
  save(3);
  EXPECT_EQ(read(*state->saved()), words(3));
}

TEST_F(SavedModuleState, IsEmptyIfTheMemoryIsDamaged) {
  save(1);
  state->copies[1].size = kMostSaved + 1;
  EXPECT_EQ(state->saved(), nullptr);
  save(2);
  state->whole.store(3);
  EXPECT_EQ(state->saved(), nullptr);
}

TEST_F(SavedModuleState, IsEmptyAfterItIsCleared) {
  save(1);
  state->clear();
  EXPECT_EQ(state->saved(), nullptr);
  save(4);
  EXPECT_EQ(read(*state->saved()), words(4));
}

TEST_F(SavedModuleState, CanBeCopiedConsistentlyWhileTheModuleSaves) {
  std::atomic<bool> end{false};
  save(1);
  std::thread saver{[&] {
    for (std::uint64_t value = 2; value < 200'000; ++value) save(value);
    end = true;
  }};
  std::uint64_t copies = 0;
  while (!end) {
    const auto copied = state->copy();
    if (!copied) continue;
    ++copies;
    const Words all = read(*copied);
    ASSERT_TRUE(std::all_of(all.begin(), all.end(), [&](std::uint64_t word) { return word == all[0]; }));
  }
  saver.join();
  EXPECT_EQ(read(*state->copy()), words(199'999));
  EXPECT_GE(copies, 0U);
}

}  // namespace
}  // namespace takt::channel::saved_state_test
