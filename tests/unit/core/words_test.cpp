#include <takt/core/words.hpp>

#include <gtest/gtest.h>
#include <full_form.hpp>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

namespace takt::words_test {
namespace {

using std::string_literals::operator""s;

TEST(QuotedText, StaysOnOneLine) {
  EXPECT_EQ(in_quotes("a\nb"), "'a\\nb'");
  EXPECT_EQ(in_quotes("a\rb\tc"), "'a\\x0db\\x09c'");
  EXPECT_EQ(in_quotes("\x1b[31m"), "'\\x1b[31m'");
  EXPECT_EQ(in_quotes("a\0b"s), "'a\\x00b'");
  EXPECT_EQ(in_quotes("\x7f"), "'\\x7f'");
  EXPECT_EQ(in_quotes("\xff\xfe"), "'\\xff\\xfe'");
  EXPECT_EQ(in_quotes("\u0085"), "'\\xc2\\x85'") << "next line";
  EXPECT_EQ(in_quotes("\u2028"), "'\\xe2\\x80\\xa8'") << "line separator";
  EXPECT_EQ(in_quotes("\u202e"), "'\\xe2\\x80\\xae'") << "right-to-left override";
  EXPECT_EQ(in_quotes("\u200f"), "'\\xe2\\x80\\x8f'") << "right-to-left mark";
  EXPECT_EQ(in_quotes("\u061c"), "'\\xd8\\x9c'") << "Arabic letter mark";
  EXPECT_EQ(in_quotes(""), "''");
  EXPECT_EQ(in_quotes("gr\u00f6\u00dfe \u20ac"), "'gr\u00f6\u00dfe \u20ac'");
}

TEST(XmlReference, NamesEachControlCharacterThatXmlAllows) {
  EXPECT_EQ(xml_reference("\r"), "&#xd;");
  EXPECT_EQ(xml_reference("\x7f"), "&#x7f;");
  EXPECT_EQ(xml_reference("\u009b"), "&#x9b;");
  EXPECT_EQ(xml_reference("\u061c"), "&#x61c;");
  EXPECT_EQ(xml_reference("\u202e"), "&#x202e;");
  EXPECT_EQ(xml_reference("\x1b"), "\\x1b") << "XML has no reference to it";
  EXPECT_EQ(xml_reference("\xff"), "\\xff") << "not UTF-8";
}

TEST(QuotedText, IsNeverCutInsideAMultibyteCharacter) {
  EXPECT_EQ(in_quotes(std::string(80, 'x')), "'" + std::string(80, 'x') + "'");
  EXPECT_EQ(in_quotes(std::string(81, 'x')), "'" + std::string(40, 'x') + "..." + std::string(20, 'x') + "'");
  for (int shift = 0; shift < 4; ++shift) {
    std::string text(static_cast<std::size_t>(shift), 'x');
    for (int i = 0; i < 100; ++i) text += "\u20ac";
    EXPECT_EQ(in_quotes(text).find('\\'), std::string::npos) << in_quotes(text);
  }
}

TEST(ProblemLocation, AlwaysNamesALine) {
  EXPECT_EQ(location("a.xml", 7), "a.xml:7");
  EXPECT_EQ(location("a.xml", 0), "a.xml:1");
  EXPECT_EQ(location("a\nb.xml", 1), "a\\nb.xml:1");
  EXPECT_EQ(location("", 7), "line 7");
}

/// Returns the edit distance: how many letters of `a` must be changed, inserted, removed or swapped with
/// their neighbour to get `b`.
std::size_t letters_apart(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> table(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      std::size_t& least = table[i][j];
      if (i == 0 || j == 0) {
        least = i + j;
        continue;
      }
      const std::size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
      least = std::min({table[i - 1][j] + 1, table[i][j - 1] + 1, table[i - 1][j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        least = std::min(least, table[i - 2][j - 2] + 1);
    }
  }
  return table[a.size()][b.size()];
}

TEST(NearestWord, DiffersByAtMostThreeEdits) {
  std::mt19937 random{1};
  std::size_t near = 0;
  const int count = how_often(200'000);
  for (int i = 0; i < count; ++i) {
    std::string word(2 + random() % 12, 'a');
    for (char& c : word) c = static_cast<char>('a' + random() % 3);
    std::string choice = word;
    for (auto slips = random() % 5; slips > 0 && !choice.empty(); --slips) {
      const std::size_t at = random() % choice.size();
      const char letter = static_cast<char>('a' + random() % 3);
      if (random() % 3 == 0) {
        choice.erase(at, 1);
      } else if (random() % 2 == 0) {
        choice.insert(at, 1, letter);
      } else {
        choice[at] = letter;
      }
    }
    const std::size_t most = std::clamp<std::size_t>((word.size() + 1) / 3, 1, 3);
    const bool is_near = !choice.empty() && letters_apart(word, choice) <= most;
    near += is_near ? 1 : 0;
    ASSERT_EQ(!nearest(word, {choice}).empty(), is_near) << word << " and " << choice;
  }
  EXPECT_GT(near, static_cast<std::size_t>(count) / 4);
  EXPECT_LT(near, static_cast<std::size_t>(count) / 20 * 19);
}

TEST(NearestWord, IsFoundOnlyForASimilarWord) {
  const std::vector<std::string_view> choices{"period", "priority", "deadline"};
  EXPECT_EQ(nearest("perod", choices), "period");
  EXPECT_EQ(nearest("preiod", choices), "period");
  EXPECT_EQ(nearest("PERIOD", choices), "period");
  EXPECT_EQ(nearest("dead-line", choices), "deadline");
  EXPECT_EQ(nearest("stail", {"kind", "stale", "topic"}), "stale");
  EXPECT_EQ(nearest("colour", choices), "");
  EXPECT_EQ(nearest("", choices), "");
  EXPECT_EQ(nearest("p", choices), "");
  EXPECT_EQ(nearest("period", {}), "");
}

TEST(Suggestion, ListsTheChoicesIfNoneIsSimilar) {
  EXPECT_EQ(suggestion("quue", {"latest", "queue"}), "did you mean queue?");
  EXPECT_EQ(suggestion("x", {"latest", "queue"}), "use latest or queue");
  EXPECT_EQ(suggestion("x", {"main"}), "use main");
  std::vector<std::string> names;
  for (int i = 0; i < 30; ++i) names.push_back("abc" + std::to_string(i));
  const std::vector<std::string_view> many{names.begin(), names.end()};
  EXPECT_NE(suggestion("xyz", many).find("and 10 more"), std::string::npos);
}

TEST(Suggestion, ListsADuplicateChoiceOnlyOnce) {
  EXPECT_EQ(suggestion("x", {"sensor", "sensor"}), "use sensor");
  EXPECT_EQ(suggestion("x", {"sensor", "robot", "sensor"}), "use sensor or robot");
  EXPECT_EQ(one_of({"main", "main"}), "main");
}

TEST(Utf8Length, AcceptsOnlyValidEncodings) {
  EXPECT_EQ(utf8_length(""), 0U);
  EXPECT_EQ(utf8_length("\x7f"), 1U);
  EXPECT_EQ(utf8_length("\u00e9"), 2U);
  EXPECT_EQ(utf8_length("\u20ac"), 3U);
  EXPECT_EQ(utf8_length("\U0001F600"), 4U);
  EXPECT_EQ(utf8_length("\U0010FFFF"), 4U);
  for (const std::string bad :
       {"\x80", "\xbf", "\xc0\x80", "\xc1\xbf", "\xe0\x80\x80", "\xed\xa0\x80", "\xf0\x80\x80\x80",
        "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff", "\xe2\x82", "\xc3", "\xe2\x28\xa1"}) {
    EXPECT_EQ(utf8_length(bad), 0U) << in_quotes(bad);
  }
}

}  // namespace
}  // namespace takt::words_test
