#include <takt/os/writers.hpp>

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <takt/os/files.hpp>

namespace takt::os::writers_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr uid_t kStranger = 54321;
constexpr gid_t kGroup = 54322;

class Writers : public testing::Test {
 protected:
  Writers() {
    fs::remove_all(home_);
    fs::create_directories(home_ / "folder/deeper");
    std::ofstream{file_} << "a file";
    rights(home_, 0755);
    rights(home_ / "folder", 0755);
    rights(home_ / "folder/deeper", 0755);
    rights(file_, 0644);
  }
  ~Writers() override { fs::remove_all(home_); }
  static void rights(const fs::path& path, mode_t mode) { ASSERT_EQ(::chmod(path.c_str(), mode), 0); }
  static void give(const fs::path& path, uid_t user, gid_t group) {
    ASSERT_EQ(::lchown(path.c_str(), user, group), 0);
  }
  static std::string problem(const fs::path& path) {
    const auto checked = check_writers(path.string());
    return checked ? "" : to_text(checked.problems());
  }

  fs::path home_ = fs::path{testing::TempDir()} / ("takt-writers-" + std::to_string(::getpid()));
  fs::path file_ = home_ / "folder/deeper/file";
};

TEST_F(Writers, AcceptsAFileInFoldersOfThisUser) {
  EXPECT_EQ(problem(file_), "");
  EXPECT_EQ(problem(file_.parent_path()), "");
}

TEST_F(Writers, RejectsAPathWithAPartThatEverybodyMayWriteTo) {
  for (const fs::path& part : {file_, home_ / "folder/deeper", home_ / "folder", home_}) {
    const mode_t before = fs::is_directory(part) ? 0755 : 0644;
    rights(part, before | 0002);
    EXPECT_THAT(problem(file_), HasSubstr("everybody may write to " + part.string() + " (owner "));
    EXPECT_THAT(problem(file_), HasSubstr(before == 0755 ? ", mode 0757)" : ", mode 0646)"));
    EXPECT_THAT(problem(file_), HasSubstr("; run chmod o-w " + part.string()));
    rights(part, before);
  }
}

TEST_F(Writers, AcceptsAFolderWithTheStickyBit) {
  rights(home_ / "folder", 01777);
  EXPECT_EQ(problem(file_), "");
}

TEST_F(Writers, RejectsALinkThroughAFolderThatEverybodyMayWriteTo) {
  fs::create_directories(home_ / "open");
  rights(home_ / "open", 0777);
  fs::create_symlink(home_ / "folder", home_ / "open/link");
  fs::create_symlink("open", home_ / "relative");
  fs::create_symlink(home_ / "open/link/deeper/file", home_ / "whole");
  for (const char* path : {"open/link/deeper/file", "relative/link/deeper/file", "whole",
                           "folder/../open/../folder/deeper/file"}) {
    EXPECT_THAT(problem(home_ / path), HasSubstr("everybody may write to " + (home_ / "open").string() + " "))
        << path;
  }
  rights(home_ / "open", 0755);
  for (const char* path : {"open/link/deeper/file", "relative/link/deeper/file", "whole"})
    EXPECT_EQ(problem(home_ / path), "") << path;
}

TEST_F(Writers, RejectsACircularLink) {
  fs::create_symlink("two", home_ / "one");
  fs::create_symlink("one", home_ / "two");
  EXPECT_THAT(problem(home_ / "one"), HasSubstr("Too many levels of symbolic links"));
}

TEST_F(Writers, AcceptsAMissingFileOnlyIfNobodyElseCanCreateIt) {
  EXPECT_EQ(problem(home_ / "folder/new/file"), "");
  EXPECT_EQ(problem(file_ / "below_a_file"), "");
  rights(home_ / "folder", 0777);
  EXPECT_THAT(problem(home_ / "folder/new/file"), HasSubstr("everybody may write to "));
}

TEST_F(Writers, RejectsAMissingFileThatOthersMayCreateInAFolderWithTheStickyBit) {
  rights(home_ / "folder", 01777);
  EXPECT_THAT(problem(home_ / "folder/new/file"),
              HasSubstr((home_ / "folder/new").string() +
                        " does not exist, and other users may create it; create it first"));
  fs::create_symlink("folder/new", home_ / "link");
  EXPECT_THAT(problem(home_ / "link"), HasSubstr("other users may create it"));
  rights(home_ / "folder", 01755);
  EXPECT_EQ(problem(home_ / "link"), "");
  EXPECT_EQ(problem(home_ / "folder/new/file"), "");
}

TEST_F(Writers, RejectsAFileToWhichAnAccessListLetsAnotherUserWrite) {
  // An access list that lets its owner and user 54321 read and write, and others only read.
  struct Entry {
    std::uint16_t tag;
    std::uint16_t rights;
    std::uint32_t id;
  };
  constexpr std::uint32_t kNobody = ~0U;
  const struct {
    std::uint32_t version = 2;
    std::array<Entry, 5> entries{
        {{1, 6, kNobody}, {2, 6, kStranger}, {4, 4, kNobody}, {16, 6, kNobody}, {32, 4, kNobody}}};
  } list;
  if (::setxattr(file_.c_str(), "system.posix_acl_access", &list, sizeof list, 0) != 0)
    GTEST_SKIP() << "no access control lists in " << home_;
  EXPECT_THAT(problem(file_),
              HasSubstr("an access control list lets other users write to " + file_.string() + " (owner "));
  EXPECT_THAT(problem(file_), HasSubstr("; run setfacl -b " + file_.string()));
}

TEST_F(Writers, ChecksEveryFolderFromTheRootToARelativePath) {
  const fs::path before = fs::current_path();
  fs::current_path(home_ / "folder");
  EXPECT_EQ(problem("deeper/file"), "");
  rights(home_, 0777);
  EXPECT_THAT(problem("deeper/file"), HasSubstr("everybody may write to " + home_.string() + " "));
  fs::current_path(before);
}

TEST_F(Writers, RejectsFilesFoldersAndLinksOfOtherUsers) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give files to other users";
  ::unsetenv("SUDO_UID");
  fs::create_symlink(file_, home_ / "link");
  for (const fs::path& part : {file_, home_ / "folder", home_ / "link"}) {
    give(part, kStranger, 0);
    EXPECT_THAT(problem(home_ / "link"),
                HasSubstr(part.string() +
                          " belongs to user 54321, who can replace it, but Takt runs as user root; run chown "
                          "-h root " +
                          part.string() + ", or run Takt as user 54321"));
    give(part, 0, 0);
  }
  EXPECT_EQ(problem(home_ / "link"), "");
}

TEST_F(Writers, AcceptsFilesOfTheUserWhoCalledSudo) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give files to other users";
  give(file_, kStranger, 0);
  ::setenv("SUDO_UID", "54321", 1);
  EXPECT_EQ(problem(file_), "");
  ::setenv("SUDO_UID", "5432", 1);
  EXPECT_THAT(problem(file_), HasSubstr("belongs to user 54321"));
  ::unsetenv("SUDO_UID");
}

TEST_F(Writers, AcceptsAFolderThatAGroupMayWriteToOnlyIfAllMembersAreTrusted) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give files to other groups";
  rights(file_.parent_path(), 0775);
  EXPECT_EQ(problem(file_), "") << "only root belongs to group root";
  give(file_.parent_path(), 0, kGroup);
  EXPECT_THAT(problem(file_),
              HasSubstr("group 54322 may write to " + file_.parent_path().string() +
                        " (owner root, mode 0775); run chmod g-w " + file_.parent_path().string()));
}

TEST_F(Writers, MakesNoPrivateFolderThatOthersCanReplace) {
  rights(home_ / "folder", 0777);
  const auto made = make_private_folder((home_ / "folder/private").string());
  ASSERT_FALSE(made.ok());
  EXPECT_THAT(made.problems()[0].what, HasSubstr("everybody may write to " + (home_ / "folder").string()));
}

TEST_F(Writers, ReplacesNoFileThroughATemporaryFileOfAnotherUser) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give files to other users";
  std::ofstream{file_.string() + ".new"} << "prepared";
  give(file_.string() + ".new", kStranger, kGroup);
  ASSERT_TRUE(replace_file(file_.string(), "mine").ok());
  struct stat status {};
  ASSERT_EQ(::stat(file_.c_str(), &status), 0);
  EXPECT_EQ(status.st_uid, 0U);
}

}  // namespace
}  // namespace takt::os::writers_test
