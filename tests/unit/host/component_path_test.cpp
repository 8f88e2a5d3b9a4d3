#include <takt/host/component_path.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <folders.hpp>

#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>
#include <takt/os/sealed_copy.hpp>
#include <takt/os/signals.hpp>

namespace takt::host::component_path_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ComponentPath : public testing::Test {
 protected:
  ComponentPath() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream{file_} << "a component";
  }
  ~ComponentPath() override {
    require_of_components(nullptr);
    fs::remove_all(folder_);
  }
  [[nodiscard]] std::string problem() const {
    const auto found = find_component("servo.so", (folder_ / "cell.xml").string());
    return found ? "" : to_text(found.problems());
  }

  fs::path folder_ =
      fs::path{testing::TempDir()} / ("takt-component-path-" + std::to_string(os::process_id()));
  std::string file_ = (folder_ / "servo.so").string();
};

TEST_F(ComponentPath, FindsAFileBesideTheDescriptor) { EXPECT_EQ(problem(), ""); }

TEST_F(ComponentPath, DoesNotFindAFileOfTheSameNameInAnotherFolder) {
  const std::string components = (folder_ / "components").string();
  fs::create_directories(components + "/mine");
  std::ofstream{components + "/arm.so"} << "a component";
  std::ofstream{components + "/mine/hand.so"} << "a component";
  ::setenv("TAKT_COMPONENT_PATH", (components + ":" + components + "-old").c_str(), 1);
  const auto problem_of = [&](const std::string& name) {
    const auto found = find_component(name, (folder_ / "cell.xml").string());
    return found ? "" : to_text(found.problems());
  };
  EXPECT_EQ(problem_of("arm.so"), "");
  EXPECT_EQ(problem_of("mine/hand.so"), "");
  EXPECT_EQ(problem_of("./servo.so"), "");
  EXPECT_THAT(
      problem_of("build/arm.so"),
      testing::AllOf(HasSubstr("there is no file build/arm.so (tried " + folder_.string() +
                               "/build/arm.so, " + components + "/build/arm.so, "),
                     HasSubstr("correct the path, or write arm.so to use " + components + "/arm.so")));
  EXPECT_THAT(problem_of("./servp.so"), HasSubstr("did you mean ./servo.so?"));
  EXPECT_THAT(problem_of("arm"), HasSubstr("did you mean arm.so?"));
  EXPECT_THAT(problem_of("nothing.so"),
              HasSubstr(components + "-old (" + components + "-old does not exist)"));

  EXPECT_TRUE(find_on_component_path("arm.so"));
  EXPECT_TRUE(find_on_component_path("mine/hand.so"));
  EXPECT_TRUE(find_on_component_path(components + "/arm.so"));
  for (const char* name : {"build/arm.so", "../servo.so", "nothing.so"})
    EXPECT_FALSE(find_on_component_path(name)) << name;
  EXPECT_FALSE(find_on_component_path(file_));
  ::unsetenv("TAKT_COMPONENT_PATH");
}

TEST_F(ComponentPath, RejectsAFileThatOtherUsersCanReplace) {
  fs::permissions(file_, fs::perms::others_write, fs::perm_options::add);
  EXPECT_THAT(problem(), HasSubstr("everybody may write to " + file_ + " (owner "));
  fs::permissions(file_, fs::perms::others_write, fs::perm_options::remove);
  fs::permissions(folder_, fs::perms::others_write, fs::perm_options::add);
  EXPECT_THAT(problem(), HasSubstr("; run chmod o-w " + folder_.string()));
}

TEST_F(ComponentPath, RejectsFilesThatTheCallersCheckRejects) {
  require_of_components(
      [](const std::string& path, const os::Fd&) -> Result<void> { return fail("no " + path); });
  EXPECT_THAT(problem(), HasSubstr("no " + file_));
  require_of_components([](const std::string&, const os::Fd&) -> Result<void> {
    return Problem{"signer.pem", "there is no such file", ""};
  });
  EXPECT_THAT(problem(), HasSubstr("signer.pem: there is no such file"));
  require_of_components([](const std::string&, const os::Fd&) { return Result<void>{}; });
  EXPECT_EQ(problem(), "");
}

std::string content_of(const os::Fd& file) { return **os::read_file(os::path_of(file), 1000); }

TEST_F(ComponentPath, OpensTheCopyThatTheCallersCheckAccepted) {
  EXPECT_FALSE(*open_component(file_)) << "without a check, the file itself is used";
  require_of_components([](const std::string& path, const os::Fd& content) -> Result<void> {
    if (content_of(content) != "a component") return fail(path + " is another");
    std::ofstream{path} << "replaced";  // after the check, and before the use
    return {};
  });
  const auto opened = open_component(file_);
  ASSERT_TRUE(opened.ok());
  EXPECT_EQ(content_of(*opened), "a component");
  const auto again = open_component(file_);
  ASSERT_FALSE(again.ok());
  EXPECT_EQ(again.problems()[0].what, file_ + " is another");
}

std::string output_of(os::Child& child) {
  std::string text;
  for (bool end = false; !end;) {
    os::wait_readable({&child.output}, -1);
    text += os::read_available(child.output, &end);
  }
  return text;
}

TEST_F(ComponentPath, StartsTheProgramThatTheCallersCheckAccepted) {
  std::ofstream{file_} << "#!/bin/sh\necho accepted\n";
  fs::permissions(file_, fs::perms::owner_all);
  require_of_components([](const std::string& path, const os::Fd&) -> Result<void> {
    std::ofstream{path} << "#!/bin/sh\necho replaced\n";
    return {};
  });
  auto child = start_component({.program = file_, .capture_output = true});
  ASSERT_TRUE(child.ok()) << to_text(child.problems());
  EXPECT_EQ(output_of(*child), "accepted\n");
  require_of_components([](const std::string&, const os::Fd&) -> Result<void> { return fail("not signed"); });
  child = start_component({.program = file_, .capture_output = true});
  ASSERT_FALSE(child.ok());
  EXPECT_EQ(child.problems()[0].what, "not signed");
}

TEST_F(ComponentPath, StartsAProgramThatHasALibraryInItsFolder) {
  for (const bool copied : {false, true}) {
    if (copied) require_of_components([](const std::string&, const os::Fd&) { return Result<void>{}; });
    auto child =
        start_component({.program = build_path("tests/objects/object_finds"), .capture_output = true});
    ASSERT_TRUE(child.ok()) << to_text(child.problems());
    EXPECT_EQ(output_of(*child), "counted 1\n") << copied;
  }
}

}  // namespace
}  // namespace takt::host::component_path_test
