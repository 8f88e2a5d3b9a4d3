// Tests malicious texts, because a node uses the same parse() for text from the network. The parser must
// reject each text with short messages, and its memory use must stay in proportion to the text. No text may
// make the parser throw or end the process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <full_form.hpp>

#include <random>
#include <string>
#include <vector>

#include <takt/descriptor/descriptor.hpp>
#include <takt/model/validate.hpp>
#include "well_formed.hpp"

namespace takt::descriptor::hostile_test {
namespace {

using testing::HasSubstr;

const std::string kModule =
    "<module><filename>a.so</filename><moduletype>thread</moduletype><operationtype>periodic</operationtype>"
    "<period>1000000</period><priority>1</priority></module>";
const std::string kDevice = "<device name='d'>" + kModule + "</device>";

/// Returns a text of at most `size` bytes: `before`, then `unit` as often as it fits, then `after`.
std::string filled(const std::string& before, const std::string& unit, const std::string& after,
                   std::size_t size = kMaxBytes) {
  const std::size_t count = (size - before.size() - after.size()) / unit.size();
  std::string units = unit;
  units.reserve(count * unit.size());
  while (2 * units.size() <= count * unit.size()) units += units;
  return before + units.append(units, 0, count * unit.size() - units.size()) + after;
}

/// The size, in bytes, of texts that are slow to parse.
std::size_t bytes() { return static_cast<std::size_t>(kSanitized && !full_form() ? 3'000'000 : 8'000'000); }

/// Expects that the parser rejects the text, and that each problem is short and on one line. Returns the
/// problems.
Problems rejected(const std::string& xml) {
  Result<model::Cell> cell = model::Cell{};
  EXPECT_NO_THROW(cell = parse(xml, "the network"));
  EXPECT_FALSE(cell) << xml.substr(0, 200);
  if (cell) return {};
  EXPECT_LE(cell.problems().size(), model::kMaxProblems);
  for (const Problem& problem : cell.problems()) {
    EXPECT_EQ(problem.where.rfind("the network:", 0), 0U) << problem.where;
    EXPECT_LT(to_text(problem).size(), 5000U);
    EXPECT_EQ(to_text(problem).find('\n'), std::string::npos);
  }
  return cell.problems();
}

std::string first_of(const std::string& xml) {
  const Problems problems = rejected(xml);
  return problems.empty() ? "nothing" : problems[0].what;
}

TEST(HostileText, WithMoreThanAMillionXmlNodesIsRejectedBeforeParsing) {
  std::string attributes;
  for (int i = 0; i < 90; ++i) attributes += " a" + std::to_string(i) + "=''";
  std::vector<std::string> units{"<a/>",     "<a" + attributes + "/>", "<!---->", "<![CDATA[]]>", "x<a/>",
                                 "<module/>"};
  if (kSanitized && !full_form()) units.resize(2);
  for (const std::string& unit : units) {
    EXPECT_THAT(first_of(filled("<root>", unit, "</root>")), HasSubstr("more than 1000000 elements")) << unit;
  }
  EXPECT_THAT(first_of(filled("<cell name='c'>" + kDevice, "<connection/>", "</cell>")),
              HasSubstr("more than 1000000 elements"));
}

// White space and closing tags do not count as XML nodes.
TEST(HostileText, WithAMillionXmlNodesIsAccepted) {
  const auto of_parts = [](std::size_t parts) {
    std::string xml = "<root>";
    for (std::size_t i = 1; i < parts; ++i) xml += "<a></a>\n";
    return xml + "</root>";
  };
  EXPECT_FALSE(find_syntax_error(of_parts(kMaxParts)));
  const auto fault = find_syntax_error(of_parts(kMaxParts + 1));
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->line, static_cast<int>(kMaxParts));
}

TEST(HostileText, WithAFewHugeXmlNodesIsRejected) {
  const std::string x(kSanitized && !full_form() ? bytes() : kMaxBytes - 1000, 'x');
  for (const std::string& xml :
       {"<" + x + "/>", "<root " + x + "='1'/>", "<cell name='" + x + "'>" + kDevice + "</cell>",
        "<root><module><filename>" + x + "</filename></module></root>",
        "<cell name='c' discovery='peers' peers='" + x + "'>" + kDevice + "</cell>",
        "<cell name='c' discovery='server' server='" + x + ":1'>" + kDevice + "</cell>",
        "<cell name='c'>" + kDevice + "<connection from='" + x + "' to='d.a.i'/></cell>",
        "<cell name='c'>" + kDevice + "<connection from='d.a.o' topic='" + x + "'/></cell>", "<!--" + x,
        "&" + x, "<root>&#" + x + ";</root>"}) {
    EXPECT_LE(rejected(xml).size(), 5U);
  }
}

TEST(HostileText, ThatExceedsTheLimitsOfACellIsRejected) {
  EXPECT_THAT(first_of(filled("<cell name='c'>" + kDevice, "<connection from='d.a.o'/>", "</cell>", bytes())),
              HasSubstr("more than 100000 connections"));
  EXPECT_EQ(
      rejected(filled("<cell name='c' discovery='peers' peers='", " a", "'>" + kDevice + "</cell>", bytes()))
          .size(),
      1U);
  EXPECT_THAT(first_of(filled("<cell name='c'>", "<device name='d'/>", "</cell>", bytes())),
              HasSubstr(" devices"));
  EXPECT_THAT(first_of(filled("<root>", "<executor name='e'/>", kModule + "</root>", bytes())),
              HasSubstr("executors"));
}

// The parser compares each misspelled name with many names, to suggest a similar name. Comparing takes time,
// so the parser limits the number of suggestions.
TEST(HostileText, WithManyMisspelledNamesIsRejectedQuickly) {
  std::string devices;
  const std::string long_name(60, 'd');
  for (int i = 100; i < 100 + how_often(900); ++i)
    devices += "<device name='" + long_name + std::to_string(i) + "'>" + kModule + "</device>";
  const std::string connection =
      "<connection from='" + long_name + "xxx.a.o' to='" + long_name + "yyy.a.i'/>";
  EXPECT_EQ(rejected(filled("<cell name='c'>" + devices, connection, "</cell>", bytes())).size(),
            model::kMaxProblems);
  EXPECT_EQ(rejected(filled("<root>", "<modul" + std::string(50, 'e') + "/>", "</root>", bytes())).size(),
            model::kMaxProblems);
}

TEST(HostileText, OfRandomBytesIsRejected) {
  std::mt19937 random{1};
  std::uniform_int_distribution<int> byte{0, 255};
  for (int i = 0; i < 2000; ++i) {
    std::string xml(static_cast<std::size_t>(i % 97), '\0');
    for (char& c : xml) c = static_cast<char>(byte(random));
    rejected(xml);
    rejected("<root>" + xml + "</root>");
    rejected("<cell name='c'>" + kDevice + "<connection from='" + xml + "'/></cell>");
  }
}

// The name of a file must not affect how the parser reads its text, and must not add a line break to a
// message.
TEST(HostileText, WithAHostileFileNameIsReportedOnOneLine) {
  for (const std::string& name :
       {std::string{}, std::string{"\n: error: nothing\n"}, std::string(100000, 'n')}) {
    const auto cell = parse("<root><x/>" + kModule + "</root>", name);
    ASSERT_FALSE(cell);
    EXPECT_EQ(to_text(cell.problems()).find('\n'), std::string::npos);
    EXPECT_TRUE(parse("<cell name='c'>" + kDevice + "</cell>", name));
    EXPECT_TRUE(parse("<root>" + kModule + "</root>", name));
  }
}

}  // namespace
}  // namespace takt::descriptor::hostile_test
