#include <takt/node/output.hpp>

#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace takt::node::output_test {
namespace {

using testing::ElementsAre;

std::vector<std::string> lines_of(const std::string& bytes) {
  std::vector<std::string> lines;
  const auto keep = [&lines](const std::string& line) { lines.push_back(line); };
  Lines splitter;
  splitter.add(bytes, keep);
  splitter.finish(keep);
  return lines;
}

TEST(Lines, KeepTextAndReplaceTabsBySpaces) {
  EXPECT_THAT(lines_of("gr\u00f6\u00dfe\ta\nb"), ElementsAre("gr\u00f6\u00dfe a", "b"));
}

TEST(Lines, ContainNoTerminalControlSequences) {
  EXPECT_THAT(lines_of("\x1b[31m"), ElementsAre("\\x1b[31m"));
  EXPECT_THAT(lines_of("\u009b31m"), ElementsAre("\\xc2\\x9b31m")) << "control sequence introducer";
  EXPECT_THAT(lines_of("\u0090q"), ElementsAre("\\xc2\\x90q")) << "device control string";
  EXPECT_THAT(lines_of("a\u202eb"), ElementsAre("a\\xe2\\x80\\xaeb")) << "right-to-left override";
  EXPECT_THAT(lines_of("\x9b"
                       "31m"),
              ElementsAre("\\x9b31m"))
      << "invalid UTF-8";
}

}  // namespace
}  // namespace takt::node::output_test
