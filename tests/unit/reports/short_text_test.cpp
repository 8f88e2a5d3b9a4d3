#include <watch/short_text.hpp>

#include <gtest/gtest.h>

namespace takt::tool::watch::short_text_test {
namespace {

TEST(ShortText, OmitsOuterBracesQuotesAroundNamesAndNeedlessDigits) {
  EXPECT_EQ(short_text(R"({"at": 0.12345678, "count": 1234567, "on": true})"),
            "at: 0.1235, count: 1234567, on: true");
  EXPECT_EQ(short_text(R"({"q": [1.0, -2.5, 3e-9], "pose": {"x": 1, "y": null}})"),
            "q: [1, -2.5, 3e-09], pose: {x: 1, y: null}");
  EXPECT_EQ(short_text("[0.5, 1]"), "[0.5, 1]");
  EXPECT_EQ(short_text("{}"), "");
}

TEST(ShortText, KeepsControlCharactersEscaped) {
  EXPECT_EQ(short_text("{\"text\": \"a\\u001b[2J\\u202e\"}"), "text: \"a\\u001b[2J\\u202e\"");
  EXPECT_EQ(short_text("no JSON"), "no JSON");
}

}  // namespace
}  // namespace takt::tool::watch::short_text_test
