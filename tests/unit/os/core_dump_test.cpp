#include <takt/os/core_dump.hpp>

#include <gtest/gtest.h>

#include <csignal>

namespace takt::os::core_dump_test {
namespace {

TEST(CoreDumpPattern, MatchesAnyTextInPlaceOfUnknownFields) {
  EXPECT_EQ(core_glob("core", 12, 11), "core");
  EXPECT_EQ(core_glob("/var/core/%e.%p.%s-%t%%", 12, 11), "/var/core/*.12.11-*%");
  EXPECT_EQ(core_glob("a*[b]%", 12, 11), "a\\*\\[b]");
  EXPECT_EQ(core_glob("", 12, 11), "");
}

TEST(FindCoreDump, FindsNoFileAfterASignalThatDumpsNoCore) {
  EXPECT_EQ(find_core_dump(12, SIGKILL).file, "");
  EXPECT_EQ(find_core_dump(12, SIGTERM).why, "");
}

}  // namespace
}  // namespace takt::os::core_dump_test
