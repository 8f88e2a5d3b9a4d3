#include <takt/os/files.hpp>

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace takt::os {
namespace {

using testing::HasSubstr;

class Files : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "takt-files-" + std::to_string(::getpid());
    std::filesystem::remove_all(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string folder_;
};

TEST_F(Files, AFileThatIsNotThereHasNoContent) {
  const auto read = read_file(folder_ + "/file", 100);
  ASSERT_TRUE(read.ok());
  EXPECT_FALSE(read->has_value());
  EXPECT_TRUE(remove_file(folder_ + "/file").ok());
}

TEST_F(Files, ReplacesWhatIsThereAndMakesTheFolder) {
  const std::string path = folder_ + "/deeper/file";
  ASSERT_TRUE(replace_file(path, "a long first content").ok());
  ASSERT_TRUE(replace_file(path, std::string{"second\0", 7}).ok());
  EXPECT_EQ(**read_file(path, 7), (std::string{"second\0", 7}));
  ASSERT_TRUE(remove_file(path).ok());
  EXPECT_TRUE(std::filesystem::is_empty(folder_ + "/deeper")) << "no temporary file is left";
}

TEST_F(Files, ReadsNoMoreThanIsAllowed) {
  const std::string path = folder_ + "/file";
  ASSERT_TRUE(replace_file(path, "12345678").ok());
  const auto read = read_file(path, 7);
  ASSERT_FALSE(read.ok());
  EXPECT_THAT(read.problems()[0].what, HasSubstr("more than 7 bytes"));
}

TEST_F(Files, ALeftoverOfAnInterruptedWriteIsNotTakenForTheFile) {
  const std::string path = folder_ + "/file";
  ASSERT_TRUE(replace_file(path, "whole").ok());
  std::ofstream{path + ".new"} << "ha";
  EXPECT_EQ(**read_file(path, 100), "whole");
  ASSERT_TRUE(replace_file(path, "next").ok());
  EXPECT_EQ(**read_file(path, 100), "next");
}

TEST_F(Files, AFailureSaysWhatAndLeavesTheOldFile) {
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

TEST_F(Files, ASectionOfAProgramIsReadByItsName) {
  const std::string self = std::filesystem::read_symlink("/proc/self/exe");
  EXPECT_EQ(read_section(self, "takt_test"), std::string(kInASection, sizeof kInASection));
  EXPECT_FALSE(read_section(self, "takt_tes"));
  EXPECT_FALSE(read_section(self, ".bss")) << "it has nothing in the file";
}

TEST_F(Files, WhatIsNoWholeObjectHasNoSection) {
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
}  // namespace takt::os
