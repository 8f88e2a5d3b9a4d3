#include <takt/model/json.hpp>

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace takt::model::json_test {
namespace {

TEST(JsonText, EscapesEveryControlCharacter) {
  EXPECT_EQ(json_text("a\x1b[2J\x7f \u0085\u009b31m \u061c\u202e\u2066 b"),
            R"("a\u001b[2J\u007f \u0085\u009b31m \u061c\u202e\u2066 b")");
}

TEST(JsonText, KeepsAllOtherCharacters) {
  const std::string text = "\u00fc \u00df \u20ac \U0001f916";
  EXPECT_EQ(json_text(text), '"' + text + '"');
}

TEST(JsonText, MeansTheSameValueWhenParsed) {
  const nlohmann::ordered_json value = {{"na\u009bme", {"\u202e", 1.5, true, nullptr, "\n\t\"\\"}}};
  EXPECT_EQ(parse_json(json_text(value)), value);
}

TEST(JsonText, ReplacesInvalidUtf8) { EXPECT_EQ(json_text("\x9b|\xe2\x80"), "\"\ufffd|\ufffd\""); }

}  // namespace
}  // namespace takt::model::json_test
