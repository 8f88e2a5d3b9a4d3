#include <takt/os/files.hpp>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <future>
#include <thread>

namespace takt::os::files_test {
namespace {

using testing::HasSubstr;

class FileAccess : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "takt-files-" + std::to_string(::getpid());
    std::filesystem::remove_all(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string folder_;
};

TEST_F(FileAccess, ReturnsNoContentForAMissingFile) {
  const auto read = read_file(folder_ + "/file", 100);
  ASSERT_TRUE(read.ok());
  EXPECT_FALSE(read->has_value());
  EXPECT_TRUE(remove_file(folder_ + "/file").ok());
}

// The file is the /proc entry of a thread. Its descriptor stays open after the thread has ended, but reading
// from it then fails.
TEST_F(FileAccess, ReturnsNoTextIfReadingFails) {
  std::promise<std::string> began;
  std::promise<void> end;
  std::thread thread{[&] {
    began.set_value("/proc/self/task/" + std::to_string(::gettid()));
    end.get_future().wait();
  }};
  const std::string folder = began.get_future().get();
  const int file = ::open((folder + "/stat").c_str(), O_RDONLY);
  const std::string path = "/proc/self/fd/" + std::to_string(file);
  EXPECT_THAT(text_of(path), HasSubstr(" ("));
  end.set_value();
  thread.join();
  while (::access(folder.c_str(), F_OK) == 0)
    std::this_thread::yield();  // the kernel removes it a little later
  EXPECT_EQ(text_of(path), "");
  ::close(file);
}

TEST_F(FileAccess, OmitsTheLineFeedAtTheEndOfAText) {
  ASSERT_TRUE(replace_file(folder_ + "/file", "one\ntwo\n").ok());
  EXPECT_EQ(text_of(folder_ + "/file"), "one\ntwo");
  EXPECT_EQ(text_of(folder_ + "/no_such"), "");
}

TEST_F(FileAccess, ReportsTheAccessRightsOfOtherUsers) {
  EXPECT_FALSE(rights_of(folder_ + "/file").has_value());
  ASSERT_TRUE(replace_file(folder_ + "/file", "mine").ok());
  const Rights mine = rights_of(folder_ + "/file").value();
  EXPECT_FALSE(mine.group_reads || mine.group_writes || mine.others_read || mine.others_write ||
               mine.is_folder);
  ASSERT_TRUE(replace_file(folder_ + "/file", "for all", Readers::everybody).ok());
  EXPECT_TRUE(rights_of(folder_ + "/file")->others_read);
  EXPECT_FALSE(rights_of(folder_ + "/file")->others_write);
  ASSERT_EQ(::chmod((folder_ + "/file").c_str(), 0622), 0);
  EXPECT_TRUE(rights_of(folder_ + "/file")->others_write);
  EXPECT_TRUE(rights_of(folder_ + "/file")->group_writes);
  EXPECT_TRUE(rights_of(folder_)->is_folder);
}

TEST_F(FileAccess, OnlyTheOwnerMayEnterAPrivateFolder) {
  ASSERT_TRUE(make_private_folder(folder_ + "/deeper/private").ok());
  struct stat status {};
  ASSERT_EQ(::stat((folder_ + "/deeper/private").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0700U);
  EXPECT_TRUE(make_private_folder(folder_ + "/deeper/private").ok()) << "it already exists";
  ASSERT_EQ(::chmod((folder_ + "/deeper/private").c_str(), 0750), 0);
  const auto open = make_private_folder(folder_ + "/deeper/private");
  ASSERT_FALSE(open.ok());
  EXPECT_THAT(open.problems()[0].fix, HasSubstr("chmod 700"));
  ASSERT_TRUE(replace_file(folder_ + "/file", "").ok());
  EXPECT_FALSE(make_private_folder(folder_ + "/file").ok());
}

TEST_F(FileAccess, CreatesTheMissingFolderOfAFileThatItWrites) {
  const std::string path = folder_ + "/deeper/file";
  ASSERT_TRUE(replace_file(path, "a long first content").ok());
  ASSERT_TRUE(replace_file(path, std::string{"second\0", 7}).ok());
  EXPECT_EQ(**read_file(path, 7), (std::string{"second\0", 7}));
  ASSERT_TRUE(remove_file(path).ok());
  EXPECT_TRUE(std::filesystem::is_empty(folder_ + "/deeper")) << "no temporary file is left";
}

TEST_F(FileAccess, RejectsAFileLargerThanTheLimit) {
  const std::string path = folder_ + "/file";
  ASSERT_TRUE(replace_file(path, "12345678").ok());
  const auto read = read_file(path, 7);
  ASSERT_FALSE(read.ok());
  EXPECT_THAT(read.problems()[0].what, HasSubstr("more than 7 bytes"));
}

TEST_F(FileAccess, IgnoresTheTemporaryFileOfAnInterruptedReplacement) {
  const std::string path = folder_ + "/file";
  ASSERT_TRUE(replace_file(path, "whole").ok());
  std::ofstream{path + ".new"} << "ha";
  EXPECT_EQ(**read_file(path, 100), "whole");
  ASSERT_TRUE(replace_file(path, "next").ok());
  EXPECT_EQ(**read_file(path, 100), "next");
}

TEST_F(FileAccess, KeepsTheOldContentIfAReplacementFails) {
  const std::string path = folder_ + "/file";
  ASSERT_TRUE(replace_file(path, "old").ok());
  std::filesystem::create_directories(path + ".new/in the way");
  const auto replaced = replace_file(path, "new");
  ASSERT_FALSE(replaced.ok());
  EXPECT_THAT(replaced.problems()[0].what, HasSubstr("file.new"));
  EXPECT_EQ(**read_file(path, 100), "old");
  EXPECT_FALSE(replace_file("/proc/nowhere/file", "x").ok());
}

__attribute__((used, section("takt_test"))) const char kInASection[] = "in a section";

TEST_F(FileAccess, ReadsASectionOfAProgramByName) {
  const std::string self = std::filesystem::read_symlink("/proc/self/exe");
  EXPECT_EQ(read_section(self, "takt_test"), std::string(kInASection, sizeof kInASection));
  EXPECT_FALSE(read_section(self, "takt_tes"));
  EXPECT_FALSE(read_section(self, ".bss")) << ".bss has no content in the file";
}

TEST_F(FileAccess, FindsNoSectionInAFileThatIsTruncatedOrNoProgram) {
  const std::string self = std::filesystem::read_symlink("/proc/self/exe");
  std::filesystem::create_directories(folder_);
  EXPECT_FALSE(read_section(folder_, "takt_test"));
  EXPECT_FALSE(read_section(folder_ + "/none", "takt_test"));
  std::string bytes(65536, '\0');
  std::ifstream{self, std::ios::binary}.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  for (const std::size_t size : {0UL, 3UL, 20UL, 64UL, 65536UL}) {
    const std::string part = folder_ + "/part";
    std::ofstream{part, std::ios::binary | std::ios::trunc} << bytes.substr(0, size);
    EXPECT_FALSE(read_section(part, "takt_test")) << size;
  }
}

}  // namespace
}  // namespace takt::os::files_test
