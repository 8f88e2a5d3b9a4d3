#include <takt/os/sealed_copy.hpp>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include <takt/os/files.hpp>

namespace takt::os::sealed_copy_test {
namespace {

using testing::HasSubstr;

class SealedCopy : public testing::Test {
 protected:
  SealedCopy() { std::ofstream{path_} << "the content"; }
  ~SealedCopy() override { std::filesystem::remove(path_); }

  std::string path_ = testing::TempDir() + "takt-sealed-" + std::to_string(::getpid());
};

TEST_F(SealedCopy, KeepsTheContentIfTheFileChanges) {
  const auto copy = sealed_copy(path_);
  ASSERT_TRUE(copy.ok()) << to_text(copy.problems());
  std::ofstream{path_} << "another";
  EXPECT_EQ(**read_file(path_of(*copy), 100), "the content");
  EXPECT_THAT(std::filesystem::read_symlink(path_of(*copy)).string(),
              HasSubstr("/memfd:" + std::filesystem::path{path_}.filename().string()));
}

TEST_F(SealedCopy, CannotBeChangedThroughAnyDescriptor) {
  const auto copy = sealed_copy(path_);
  EXPECT_LT(::pwrite(copy->get(), "x", 1, 0), 0);
  EXPECT_LT(::ftruncate(copy->get(), 3), 0);
  const Fd again{::open(path_of(*copy).c_str(), O_RDWR)};
  EXPECT_LT(::pwrite(again.get(), "x", 1, 0), 0);
  EXPECT_LT(::fcntl(copy->get(), F_ADD_SEALS, 0), 0);
  EXPECT_EQ(**read_file(path_of(*copy), 100), "the content");
}

TEST_F(SealedCopy, RejectsWhatIsNotAReadableFile) {
  EXPECT_THAT(to_text(sealed_copy(path_ + "-missing").problems()), HasSubstr("-missing: No such file"));
  EXPECT_THAT(to_text(sealed_copy("/").problems()), HasSubstr("is not a file"));
  std::filesystem::remove(path_);
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  EXPECT_THAT(to_text(sealed_copy(path_).problems()), HasSubstr("is not a file"));
}

}  // namespace
}  // namespace takt::os::sealed_copy_test
