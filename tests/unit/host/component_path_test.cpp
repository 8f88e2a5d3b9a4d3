#include <takt/host/component_path.hpp>

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>

#include <takt/os/environment.hpp>

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

TEST_F(ComponentPath, RejectsAFileOrFolderThatEverybodyMayWriteTo) {
  fs::permissions(file_, fs::perms::others_write, fs::perm_options::add);
  EXPECT_THAT(problem(), HasSubstr("everybody may write to " + file_ + "; run chmod o-w " + file_));
  fs::permissions(file_, fs::perms::others_write, fs::perm_options::remove);
  fs::permissions(folder_, fs::perms::others_write, fs::perm_options::add);
  EXPECT_THAT(problem(), HasSubstr("everybody may write to " + folder_.string() + "; run chmod o-w"));
}

TEST_F(ComponentPath, RejectsFilesThatTheCallersCheckRejects) {
  require_of_components([](const std::string& path) -> Result<void> { return fail("no " + path); });
  EXPECT_THAT(problem(), HasSubstr("no " + file_));
  require_of_components([](const std::string&) -> Result<void> {
    return Problem{"signer.pem", "there is no such file", ""};
  });
  EXPECT_THAT(problem(), HasSubstr("signer.pem: there is no such file"));
  require_of_components([](const std::string&) { return Result<void>{}; });
  EXPECT_EQ(problem(), "");
}

}  // namespace
}  // namespace takt::host::component_path_test
