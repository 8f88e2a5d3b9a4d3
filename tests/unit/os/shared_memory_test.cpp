#include <takt/os/shared_memory.hpp>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <new>
#include <utility>

namespace takt::os::shared_memory_test {
namespace {

TEST(SharedMemory, IsZeroWhenCreated) {
  const auto memory = SharedMemory::create("test", 10'000);
  ASSERT_TRUE(memory.ok());
  EXPECT_EQ(memory->size(), 10'000U);
  EXPECT_TRUE(std::all_of(memory->data(), memory->data() + memory->size(),
                          [](std::byte b) { return b == std::byte{0}; }));
}

TEST(SharedMemory, IsSharedWithAnotherProcess) {
  const auto memory = SharedMemory::create("test", 4096);
  auto* word = new (memory->data()) std::atomic<int>{1};
  const int child = ::fork();
  if (child == 0) {
    const auto theirs = SharedMemory::attach(Fd{::dup(memory->fd().get())});
    reinterpret_cast<std::atomic<int>*>(theirs->data())->store(42);
    ::_exit(0);
  }
  ::waitpid(child, nullptr, 0);
  EXPECT_EQ(word->load(), 42);
}

TEST(SharedMemoryDeathTest, IsReadOnlyInTheFirstPagesIfAskedFor) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const auto memory = SharedMemory::create("test", 3 * page);
  auto theirs = SharedMemory::attach(Fd{::dup(memory->fd().get())});
  ASSERT_TRUE(theirs->make_read_only(2 * page - 1));
  memory->data()[0] = std::byte{7};
  EXPECT_EQ(theirs->data()[0], std::byte{7});
  theirs->data()[page] = std::byte{8};
  EXPECT_EQ(memory->data()[page], std::byte{8}) << "only part of this page was to be read-only";
  EXPECT_DEATH(theirs->data()[page - 1] = std::byte{1}, "");  // a sanitizer ends the process in its own way
}

TEST(SharedMemory, CannotBeResized) {
  const auto memory = SharedMemory::create("test", 8192);
  EXPECT_NE(::ftruncate(memory->fd().get(), 0), 0);
  EXPECT_NE(::ftruncate(memory->fd().get(), 1 << 20), 0);
}

TEST(SharedMemory, IsNotInheritedUnlessPassed) {
  const auto memory = SharedMemory::create("test", 4096);
  EXPECT_NE(::fcntl(memory->fd().get(), F_GETFD) & FD_CLOEXEC, 0);
}

TEST(SharedMemory, KeepsItsAddressWhenMoved) {
  auto first = SharedMemory::create("test", 4096);
  std::byte* data = first->data();
  SharedMemory second{std::move(*first)};
  EXPECT_EQ(second.data(), data);
  SharedMemory third;
  third = std::move(second);
  EXPECT_EQ(third.data(), data);
  third.data()[0] = std::byte{1};
}

TEST(SharedMemory, RejectsAnInvalidDescriptorOrSize) {
  EXPECT_FALSE(SharedMemory::attach(Fd{}).ok());
  EXPECT_FALSE(SharedMemory::create("test", 0).ok());
  EXPECT_FALSE(SharedMemory::attach(Fd{::open("/dev/null", O_RDONLY)}).ok());
}

}  // namespace
}  // namespace takt::os::shared_memory_test
