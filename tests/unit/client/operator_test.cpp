#include <takt/client/operator.hpp>

#include <gmock/gmock.h>

#include <takt/wire/words.hpp>

namespace takt::client::operator_test {
namespace {

wire::WholeReply reply(const std::string& data) {
  wire::WholeReply reply;
  wire::set(reply.head.device(), "robot");
  wire::set(reply.head.text(), "it failed");
  reply.data = data;
  return reply;
}

TEST(CheckedRequest, RejectsAValueThatIsTooLong) {
  CommandRequest request{.kind = COMMAND_SET, .device = "robot", .module = "m", .property = "p"};
  request.value = std::string(255, 'x');
  EXPECT_TRUE(check(request).ok());
  request.value += 'x';
  ASSERT_FALSE(check(request).ok());
  EXPECT_THAT(to_text(check(request).problems()),
              testing::AllOf(testing::HasSubstr("has 256 bytes"), testing::HasSubstr("at most 255 bytes")));
}

TEST(CheckedRequest, RejectsANameThatIsTooLongOrInvalid) {
  EXPECT_TRUE(check({.device = std::string(63, 'x')}).ok());
  for (const std::string& name : {std::string(64, 'x'), std::string{"a\x01"}}) {
    EXPECT_FALSE(check({.device = name}).ok());
    EXPECT_FALSE(check({.device = "d", .module = name}).ok());
    EXPECT_FALSE(check({.device = "d", .property = name}).ok());
  }
}

TEST(ProblemsOf, ListsTheProblemsInTheData) {
  EXPECT_EQ(problems_of(reply(R"([{"where": "cell.xml:3", "what": "no period", "fix": "add one"}])")),
            (Problems{{"cell.xml:3", "no period", "add one"}}));
}

TEST(ProblemsOf, ToleratesMalformedData) {
  const Problems only_text{{"device robot", "it failed", ""}};
  for (const char* data : {"", "no JSON", "5", "{}", "[]", "[5, []]", R"([{"where": "x"}])"})
    EXPECT_EQ(problems_of(reply(data)), only_text) << data;
  EXPECT_EQ(problems_of(reply(R"([{"where": 5, "what": {}, "fix": null}])")), (Problems{{"", "", ""}}));
}

}  // namespace
}  // namespace takt::client::operator_test
