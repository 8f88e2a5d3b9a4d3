#include <takt/node/retained.hpp>

#include <gmock/gmock.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <temporary_folder.hpp>

#include "whole_file.hpp"

namespace takt::node::retained_test {
namespace {

using testing::HasSubstr;

class RetainedState : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void save(const std::string& text, std::uint32_t version = 1) {
    state->save(text.data(), static_cast<std::uint32_t>(text.size()), version, 0);
  }
  static std::string text_of(const channel::SavedState& state) {
    const auto* place = state.saved();
    if (place == nullptr) return "nothing";
    return {reinterpret_cast<const char*>(place->bytes.data()), place->size};
  }
  std::string read_back() const {
    const auto other = std::make_unique<channel::SavedState>();
    const auto read = file_.read_into(*other);
    return read ? text_of(*other) : in_words(read.problems());
  }

  std::string folder_ = temporary_folder("retained");
  SavedFile file_{folder_, "cell", "robot", "servo"};
  std::unique_ptr<channel::SavedState> state = std::make_unique<channel::SavedState>();
};

TEST_F(RetainedState, IsReadBackWithItsVersion) {
  const std::string bytes{"\0\xff\x10 end", 7};
  save(bytes, 42);
  ASSERT_TRUE(file_.write(*state->saved()).ok());
  EXPECT_EQ(file_.path(), folder_ + "/cell.robot.servo.saved");
  const auto other = std::make_unique<channel::SavedState>();
  ASSERT_TRUE(file_.read_into(*other).ok());
  EXPECT_EQ(text_of(*other), bytes);
  EXPECT_EQ(other->saved()->version, 42U);
}

TEST_F(RetainedState, IsEmptyIfItHasNoFile) { EXPECT_EQ(read_back(), "nothing"); }

TEST_F(RetainedState, IsRejectedIfAnyByteIsDamaged) {
  save("some state");
  ASSERT_TRUE(file_.write(*state->saved()).ok());
  std::ifstream in{file_.path()};
  const std::string whole{std::istreambuf_iterator<char>{in}, {}};
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string other = whole;
    other[i] ^= 1;
    std::ofstream{file_.path()} << other;
    ASSERT_THAT(read_back(), HasSubstr("is damaged")) << i;
    std::ofstream{file_.path()} << whole.substr(0, i);
    ASSERT_THAT(read_back(), HasSubstr("is damaged")) << i;
  }
}

TEST_F(RetainedState, IsRejectedIfItsVersionIsInvalid) {
  for (const char* version : {"-1", "1.5", "1e300", "4294967296"}) {
    const std::string body = "{\"version\":" + std::string{version} + R"(,"bytes":"00"})";
    ASSERT_TRUE(write_whole(file_.path(), "takt saved 1", body).ok());
    EXPECT_THAT(read_back(), HasSubstr("is damaged")) << version;
  }
}

TEST_F(RetainedState, IsWrittenToDiskWhenItsWriterStops) {
  {
    auto retained = Retained::start({{.file = file_, .state = state.get()}}, [](const std::string&) {});
    ASSERT_TRUE(retained.ok());
    save("first");
    save("last");
  }
  EXPECT_EQ(read_back(), "last");
  {
    auto retained =
        Retained::start({{.file = file_, .state = state.get(), .written = 2}}, [](const std::string&) {});
    state->clear();
  }
  EXPECT_EQ(read_back(), "nothing");
}

TEST_F(RetainedState, IsDeletedFromDiskByTheNextUpdateAfterItIsCleared) {
  save("old");
  ASSERT_TRUE(file_.write(*state->saved()).ok());
  auto retained = Retained::start(
      {{.file = file_, .state = state.get(), .written = 1}}, [](const std::string&) {},
      std::chrono::hours{1});
  ASSERT_TRUE(retained.ok());
  state->clear();
  (*retained)->update();
  while (!(*retained)->updated(*state)) std::this_thread::yield();
  EXPECT_TRUE((*retained)->updated(*state)->ok());
  EXPECT_EQ(read_back(), "nothing");
}

TEST_F(RetainedState, ReportsThatAnUpdateFailed) {
  std::filesystem::create_directories(file_.path() + "/in the way");
  auto retained = Retained::start(
      {{.file = file_, .state = state.get(), .written = 1}}, [](const std::string&) {},
      std::chrono::hours{1});
  ASSERT_TRUE(retained.ok());
  (*retained)->update();
  while (!(*retained)->updated(*state)) std::this_thread::yield();
  ASSERT_FALSE((*retained)->updated(*state)->ok());
  EXPECT_THAT(in_words((*retained)->updated(*state)->problems()), HasSubstr(file_.path()));
}

TEST_F(RetainedState, ReportsAFailedWriteAndTheRecoveryOnceEach) {
  std::filesystem::remove_all(folder_);
  std::ofstream{folder_} << "a file where a folder should be";
  std::mutex mutex;
  std::vector<std::string> reports;
  const auto has_reports = [&](std::size_t count) {
    const std::lock_guard lock{mutex};
    return reports.size() >= count;
  };
  save("some");
  {
    auto retained = Retained::start(
        {{.file = file_, .state = state.get()}},
        [&](const std::string& text) {
          const std::lock_guard lock{mutex};
          reports.push_back(text);
        },
        std::chrono::microseconds{1});
    while (!has_reports(1)) std::this_thread::yield();
    for (int i = 0; i < 100; ++i) {
      save("more");
      std::this_thread::yield();
    }
    std::filesystem::remove(folder_);
    while (!has_reports(2)) std::this_thread::yield();
  }
  ASSERT_EQ(reports.size(), 2U);
  EXPECT_THAT(reports[0], HasSubstr("cannot write the state that modules retain to disk: " + folder_));
  EXPECT_THAT(reports[1], HasSubstr("on disk again: " + file_.path()));
  EXPECT_EQ(read_back(), "more");
}

}  // namespace
}  // namespace takt::node::retained_test
