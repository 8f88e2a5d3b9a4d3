#include <gtest/gtest.h>

#include <string>

#include <takt/model/validate.hpp>

namespace takt::model {
namespace {

TEST(Name, IsRefusedForEachOtherForm) {
  for (const char* name :
       {"", "7axis", "-a", "a.b", "a b", " a", "a ", "a/b", "gr\u00f6\u00dfe", "a\n", "a:b", "a+"}) {
    EXPECT_FALSE(is_valid_name(name)) << name;
  }
  EXPECT_FALSE(is_valid_name(std::string(64, 'a')));
  EXPECT_FALSE(is_valid_name(std::string_view{"a\0", 2}));
}

TEST(Name, IsLetterOrUnderscoreThenAlsoDigitsAndDashes) {
  for (const char* name : {"a", "Z", "_", "a7", "_7", "a-b", "trajectory_2", "A-"})
    EXPECT_TRUE(is_valid_name(name)) << name;
  EXPECT_TRUE(is_valid_name(std::string(63, 'a')));
}

TEST(FileStem, IsTheFileWithoutFolderAndEnding) {
  EXPECT_EQ(file_stem("build/controller1.so"), "controller1");
  EXPECT_EQ(file_stem("./control2.so"), "control2");
  EXPECT_EQ(file_stem("vision.exe"), "vision");
  EXPECT_EQ(file_stem("/usr/bin/vision"), "vision");
  EXPECT_EQ(file_stem("a.b/servo"), "servo");
  EXPECT_EQ(file_stem("lib.servo.so"), "lib.servo");
  EXPECT_EQ(file_stem(".so"), ".so");
  EXPECT_EQ(file_stem("folder/"), "");
  EXPECT_EQ(file_stem(""), "");
}

}  // namespace
}  // namespace takt::model
