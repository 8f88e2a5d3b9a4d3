#include <takt/node/violations.hpp>

#include <gmock/gmock.h>

namespace takt::node::violations_test {
namespace {

TEST(ViolationText, LeavesOutTheCallsWithinSystemLibraries) {
  const SeenViolation write{
      .module = 0,
      .hook = "run()",
      .kind = "system call",
      .what = "write",
      .calls = {"__write in libc.so.6", "std::flush in libstdc++.so.6", "show at x.cpp:3 in x.so"}};
  EXPECT_EQ(sentence_of(write), "write, a system call, in show at x.cpp:3 in x.so");
}

TEST(ViolationText, NamesOnlyTheFourInnermostCalls) {
  const SeenViolation deep{.hook = "run()",
                           .kind = "allocation",
                           .what = "malloc",
                           .calls = {"a in x.so", "b in x.so", "c in x.so", "d in x.so", "e in x.so"}};
  EXPECT_EQ(sentence_of(deep),
            "malloc, an allocation, in a in x.so, called by b in x.so, called by c in x.so, called by d in "
            "x.so, ...");
}

TEST(ViolationText, IsOnlyTheKindIfNothingElseIsKnown) {
  EXPECT_EQ(sentence_of({.hook = "run()", .kind = "page fault", .what = ""}), "a page fault");
}

}  // namespace
}  // namespace takt::node::violations_test
