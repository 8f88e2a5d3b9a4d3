#include <takt/os/thread_use.hpp>

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include <takt/os/real_time.hpp>

namespace takt::os::thread_use_test {
namespace {

namespace fs = std::filesystem;

class ThreadStatistics : public testing::Test {
 protected:
  ThreadStatistics() {
    char path[] = "/tmp/takt-thread-XXXXXX";
    root = ::mkdtemp(path);
  }
  ~ThreadStatistics() override { fs::remove_all(root); }
  void write(const std::string& path, const std::string& text) {
    fs::create_directories(fs::path{root + path}.parent_path());
    std::ofstream{root + path} << text;
  }
  std::string root;
};

std::string stat_line(const std::string& name, const std::string& state) {
  std::string line = "7 (" + name + ") " + state;
  for (int place = 4; place <= 52; ++place) line += " " + std::to_string(place * 100);
  return line + "\n";
}

TEST_F(ThreadStatistics, AreReadFromTheFilesOfTheKernel) {
  write("/proc/7/task/7/stat", stat_line("odd) name (", "S"));
  write("/proc/7/task/7/schedstat", "123456 7890 12\n");
  write("/proc/7/task/7/status", "Name:\tx\nvoluntary_ctxt_switches:\t5\nnonvoluntary_ctxt_switches:\t11\n");
  const auto use = read_thread_use(7, root);
  ASSERT_TRUE(use);
  EXPECT_EQ(use->minor_faults, 1000U);
  EXPECT_EQ(use->major_faults, 1200U);
  EXPECT_EQ(use->cpu, 3900);
  EXPECT_EQ(use->ran, Nanoseconds{123456});
  EXPECT_EQ(use->waited, Nanoseconds{7890});
  EXPECT_EQ(use->gave_way, 11U);
  EXPECT_FALSE(use->stopped);
}

TEST_F(ThreadStatistics, ShowWhetherAThreadIsReadyOrStopped) {
  for (const char* state : {"T", "t", "S", "R"}) {
    write("/proc/7/task/7/stat", stat_line("x", state));
    EXPECT_EQ(read_thread_use(7, root)->ready, *state == 'R') << state;
    EXPECT_EQ(read_thread_use(7, root)->stopped, *state == 'T' || *state == 't') << state;
  }
}

TEST_F(ThreadStatistics, AreMissingIfThereIsNoSuchThread) {
  EXPECT_FALSE(read_thread_use(7, root));
  write("/proc/7/task/7/stat", "");
  EXPECT_FALSE(read_thread_use(7, root));
}

TEST_F(ThreadStatistics, ReportNoTimesWithoutSchedulerStatistics) {
  write("/proc/7/task/7/stat", stat_line("x", "R"));
  EXPECT_EQ(read_thread_use(7, root)->waited, Nanoseconds{0});
  EXPECT_FALSE(read_thread_use(7, root)->ran);
}

TEST(ThreadUse, CountsThePageFaultsOfThisThread) {
  const auto before = read_thread_use(thread_id());
  ASSERT_TRUE(before);
  constexpr std::size_t kSize = 1 << 20U;
  void* const memory =  // new pages, which std::vector might not get
      ::mmap(nullptr, kSize, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  std::memset(memory, 1, kSize);
  const auto after = read_thread_use(thread_id());
  ::munmap(memory, kSize);
  ASSERT_TRUE(after);
  EXPECT_GT(after->minor_faults, before->minor_faults);
  EXPECT_GE(after->waited, before->waited);
  EXPECT_GE(after->cpu, 0);
}

TEST_F(ThreadStatistics, ContainTheStolenTimeOfEachCpu) {
  write("/proc/stat",
        "cpu  1 2 3 4 5 6 7 80 9 10\ncpu0 1 2 3 4 5 6 7 30 9 10\ncpu2 1 2 3 4 5 6 7 50 9 10\nintr 5\n");
  const auto stolen = read_stolen(root);
  ASSERT_EQ(stolen.size(), 3U);
  EXPECT_EQ(stolen[0], std::chrono::milliseconds{300});
  EXPECT_EQ(stolen[1], Nanoseconds{0});
  EXPECT_EQ(stolen[2], std::chrono::milliseconds{500});
  EXPECT_TRUE(read_stolen(root + "/none").empty());
}

}  // namespace
}  // namespace takt::os::thread_use_test
