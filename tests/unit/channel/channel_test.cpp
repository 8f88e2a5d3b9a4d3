#include <takt/channel/channel.hpp>

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

namespace takt::channel::channel_test {
namespace {

/// Returns a new file descriptor for the same memory, as another process would have.
os::Fd again(const os::Fd& fd) { return os::Fd{::dup(fd.get())}; }

TEST(Channel, ContainsOnlyNamesAndZerosWhenCreated) {
  const auto channel = Channel::create(2, {"main", "motion"}, {"a", "b", "c"});
  ASSERT_TRUE(channel.ok());
  EXPECT_EQ(channel->hosts(), 2U);
  EXPECT_EQ(channel->host(1).t0_ns.load(), 0);
  EXPECT_EQ(channel->executors(), 2U);
  EXPECT_EQ(channel->modules(), 3U);
  EXPECT_EQ(channel->executor(1).name.view(), "motion");
  EXPECT_EQ(channel->module(2).name.view(), "c");
  EXPECT_EQ(channel->host(0).t0_ns.load(), 0);
  EXPECT_EQ(channel->module(0).in_tables.load(), 0U);
  EXPECT_EQ(channel->module(0).jitter.read().count, 0U);
  EXPECT_EQ(channel->executor(0).row.module.load(), 0U);
}

TEST(Channel, IsSharedWithEveryProcessThatAttaches) {
  const auto mine = Channel::create(1, {"main"}, {"a", "b"});
  const auto theirs = Channel::attach(again(mine->fd()));
  ASSERT_TRUE(theirs.ok()) << to_text(theirs.problems());
  EXPECT_EQ(theirs->modules(), 2U);
  EXPECT_EQ(theirs->module(1).name.view(), "b");
  mine->module(1).cycles.store(7);
  theirs->executor(0).next_row.store(9);
  theirs->host(0).t0_ns.store(11);
  EXPECT_EQ(theirs->module(1).cycles.load(), 7U);
  EXPECT_EQ(mine->executor(0).next_row.load(), 9U);
  EXPECT_EQ(mine->host(0).t0_ns.load(), 11);
}

TEST(Channel, CanBeCreatedWithoutExecutorsAndModules) {
  const auto mine = Channel::create(1, {}, {});
  ASSERT_TRUE(mine.ok());
  EXPECT_TRUE(Channel::attach(again(mine->fd())).ok());
}

TEST(Channel, StaysValidAfterItsCreatorHasClosedIt) {
  Channel theirs;
  {
    const auto mine = Channel::create(1, {"main"}, {"a"});
    mine->module(0).cycles.store(3);
    theirs = std::move(Channel::attach(again(mine->fd())).value());
  }
  EXPECT_EQ(theirs.module(0).cycles.load(), 3U);
}

TEST(Channel, AlignsEachBlockToACacheLine) {
  const auto channel = Channel::create(1, {"main", "other"}, {"a", "b"});
  for (const void* block :
       {static_cast<const void*>(&channel->host(0)), static_cast<const void*>(&channel->executor(1)),
        static_cast<const void*>(&channel->module(1))}) {
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(block) % 64, 0U);
  }
}

TEST(Channel, RejectsMemoryCreatedByAnotherVersion) {
  const auto mine = Channel::create(1, {"main"}, {"a"});
  auto view = os::SharedMemory::attach(again(mine->fd()));
  std::uint64_t magic = 0;
  std::memcpy(&magic, view->data(), sizeof magic);
  magic += 1;
  std::memcpy(view->data(), &magic, sizeof magic);
  const auto theirs = Channel::attach(again(mine->fd()));
  ASSERT_FALSE(theirs.ok());
  EXPECT_EQ(theirs.problems()[0].what, "another version of Takt created the channel");
  EXPECT_EQ(theirs.problems()[0].fix, "install takt-node and takt-host of the same version");
}

TEST(Channel, RejectsMemoryWhoseSizeDoesNotMatchItsHeader) {
  const auto mine = Channel::create(1, {"main"}, {"a"});
  auto view = os::SharedMemory::attach(again(mine->fd()));
  // For some of these numbers of modules, the computation of the memory size overflows 64 bits.
  for (const std::uint64_t modules :
       {std::uint64_t{0}, std::uint64_t{2}, ~std::uint64_t{0}, (std::uint64_t{1} << 60) + 1}) {
    std::memcpy(view->data() + 24, &modules, sizeof modules);
    EXPECT_FALSE(Channel::attach(again(mine->fd())).ok()) << modules;
  }
}

TEST(Channel, RejectsMemoryThatIsTooSmall) {
  auto memory = os::SharedMemory::create("small", 32);
  const auto theirs = Channel::attach(again(memory->fd()));
  ASSERT_FALSE(theirs.ok());
  EXPECT_EQ(theirs.problems()[0].what, "the shared memory of the host is not a channel");
  EXPECT_FALSE(Channel::attach(os::Fd{}).ok());
  auto nothing = os::SharedMemory::create("empty", 4096);
  EXPECT_FALSE(Channel::attach(again(nothing->fd())).ok());
}

}  // namespace
}  // namespace takt::channel::channel_test
