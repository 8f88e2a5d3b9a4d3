#include "scaffold/scaffold.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::tool::scaffold_test {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

std::vector<std::string> names(const std::vector<NewFile>& files) {
  std::vector<std::string> names;
  for (const NewFile& file : files) names.push_back(file.name);
  return names;
}
const std::string& text_of(const std::vector<NewFile>& files, const std::string& name) {
  for (const NewFile& file : files)
    if (file.name == name) return file.text;
  throw std::out_of_range(name);
}

TEST(Scaffold, WritesAllFilesOfAComponent) {
  const auto files = new_component({.name = "belt_drive"});
  ASSERT_TRUE(files);
  EXPECT_THAT(names(*files),
              UnorderedElementsAre("CMakeLists.txt", "README.md", "belt_drive.cpp", "belt_drive.xml",
                                   "belt_drive_test.cpp", "belt_drive_types.idl"));
  EXPECT_THAT(text_of(*files, "belt_drive.cpp"), HasSubstr("class BeltDrive : public takt::Component"));
  EXPECT_THAT(text_of(*files, "belt_drive.xml"), HasSubstr("<period>"));
  EXPECT_THAT(text_of(*files, "belt_drive.xml"), HasSubstr(R"(to="here.belt_drive.in"/>)"));
}
TEST(Scaffold, LeavesNoPlaceholderInTheFiles) {
  for (const auto type : {model::ModuleType::thread, model::ModuleType::process}) {
    for (const auto operation : {model::Operation::periodic, model::Operation::sporadic}) {
      for (const bool in_c : {false, true}) {
        const auto files = new_component({"pump", type, operation, in_c});
        ASSERT_TRUE(files);
        EXPECT_EQ(files->size(), 6U);
        for (const NewFile& file : *files) {
          EXPECT_THAT(file.text, Not(ContainsRegex("@[A-Za-z]+@"))) << file.name;
          EXPECT_FALSE(file.text.empty()) << file.name;
        }
      }
    }
  }
  const auto cell = new_cell("plant");
  ASSERT_TRUE(cell);
  for (const NewFile& file : *cell) EXPECT_THAT(file.text, Not(ContainsRegex("@[A-Za-z]+@"))) << file.name;
}
TEST(Scaffold, WritesFilesForTheRequestedModuleAndOperationType) {
  const auto files = new_component({"pump", model::ModuleType::process, model::Operation::sporadic, true});
  ASSERT_TRUE(files);
  EXPECT_THAT(text_of(*files, "CMakeLists.txt"), HasSubstr("takt_add_process(pump pump.c TYPES pump_types)"));
  EXPECT_THAT(text_of(*files, "pump.xml"), HasSubstr("<filename>pump.exe</filename>"));
  EXPECT_THAT(text_of(*files, "pump.xml"), HasSubstr("<deadline>"));
  EXPECT_THAT(text_of(*files, "pump.xml"), HasSubstr(R"(to="here.pump.in" kind="queue" depth="8"/>)"));
  EXPECT_THAT(text_of(*files, "pump.c"), HasSubstr("waitSporadic()"));
}
TEST(Scaffold, RejectsComponentNamesThatWouldNotCompile) {
  for (const char* name :
       {"", "2nd", "Pump", "belt-drive", "a b", "a__b", "a_", "../a", "test", "takt", "p\xc3\xbcmpe"})
    EXPECT_FALSE(new_component({.name = name})) << name;
  EXPECT_FALSE(new_component({.name = std::string(49, 'a')}));
  EXPECT_TRUE(new_component({.name = std::string(48, 'a')}));
  EXPECT_TRUE(new_component({.name = "int"})) << "the generated code has no identifier int";
  EXPECT_FALSE(new_cell("a b"));
  EXPECT_TRUE(new_cell("Line-1"));
}

}  // namespace
}  // namespace takt::tool::scaffold_test
