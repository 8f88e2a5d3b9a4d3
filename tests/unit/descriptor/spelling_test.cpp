// Tests that all spellings of the same XML give the same cell: other quotes, another order, or character
// references. Otherwise an editor that reformats a descriptor could change the cell.
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <folders.hpp>
#include <takt/core/words.hpp>
#include <takt/descriptor/descriptor.hpp>

#include "cell_text.hpp"

namespace takt::descriptor::spelling_test {
namespace {

const std::string kGood = source_path("tests/unit/descriptor/cases/good/");

std::string content_of(const std::string& file) {
  std::ostringstream content;
  content << std::ifstream{file, std::ios::binary}.rdbuf();
  return content.str();
}

std::string cell_text(const std::string& xml) {
  const auto cell = parse(xml, "f.xml");
  return cell ? text_of_cell(*cell) : "rejected: " + to_text(cell.problems());
}

/// Returns `text` with each match of the pattern replaced by the text that `make` returns for it.
std::string each(const std::string& text, const std::string& pattern,
                 const std::function<std::string(const std::smatch&)>& make) {
  const std::regex expression{pattern};
  std::string result;
  auto at = text.cbegin();
  for (std::sregex_iterator match{text.begin(), text.end(), expression}, end; match != end; ++match) {
    result.append(at, match->prefix().second).append(make(*match));
    at = (*match)[0].second;
  }
  return result.append(at, text.cend());
}

std::string as_references(const std::string& text, bool hex) {
  std::ostringstream result;
  for (const char c : text) {
    if (hex) {
      result << "&#x" << std::hex << static_cast<int>(c) << ";";
    } else {
      result << "&#" << static_cast<int>(c) << ";";
    }
  }
  return result.str();
}

const std::string kAttribute = R"re(([a-z-]+)="([^"]*)")re";
const std::string kTagWithAttributes = R"re(<([a-z]+)((?: [a-z-]+="[^"]*")+)(/?)>)re";

/// Returns other spellings of `xml` that have the same meaning. `xml` has no XML declaration and no comments.
std::vector<std::pair<std::string, std::string>> spellings(const std::string& xml) {
  const auto attributes =
      [&](const std::function<std::string(const std::string&, const std::string&)>& make) {
        return each(xml, kAttribute, [&](const std::smatch& m) { return make(m[1], m[2]); });
      };
  return {
      {"single quotes", attributes([](auto name, auto value) { return name + "='" + value + "'"; })},
      {"blanks around =", attributes([](auto name, auto value) { return name + " \n=\t\"" + value + "\""; })},
      {"blanks in values",
       attributes([](auto name, auto value) { return name + "=\" \n" + value + "\t\""; })},
      {"decimal references",
       attributes([](auto name, auto value) { return name + "=\"" + as_references(value, false) + "\""; })},
      {"hexadecimal references",
       attributes([](auto name, auto value) { return name + "=\"" + as_references(value, true) + "\""; })},
      {"attributes in another order",
       each(xml, kTagWithAttributes,
            [](const std::smatch& tag) {
              const std::string all = tag[2];
              std::vector<std::string> one;
              const std::regex attribute{" [a-z-]+=\"[^\"]*\""};
              for (std::sregex_iterator at{all.begin(), all.end(), attribute}, end; at != end; ++at)
                one.push_back(at->str());
              std::string turned;
              for (auto at = one.rbegin(); at != one.rend(); ++at) turned += *at;
              return "<" + tag[1].str() + turned + tag[3].str() + ">";
            })},
      {"one attribute per line",
       each(xml, R"re( ([a-z-]+="))re", [](const auto& m) { return "\n  " + m[1].str(); })},
      {"empty elements with two tags",
       each(xml, R"(<([a-z]+)([^<>]*)/>)",
            [](const auto& m) { return "<" + m[1].str() + m[2].str() + "></" + m[1].str() + ">"; })},
      {"texts as CDATA",
       each(xml, R"(>([^<>\s][^<>]*)</)", [](const auto& m) { return "><![CDATA[" + m[1].str() + "]]></"; })},
      {"texts in two pieces",
       each(xml, R"(>([^<>\s])([^<>]*)</)",
            [](const auto& m) { return ">" + m[1].str() + "<!-- and -->" + m[2].str() + "</"; })},
      {"texts as references", each(xml, R"(>([^<>\s][^<>]*)</)",
                                   [](const auto& m) { return ">" + as_references(m[1], true) + "</"; })},
      {"Windows line ends", each(xml, "\n", [](const auto&) { return "\r\n"; })},
      {"all on one line", each(xml, "\n *", [](const auto&) { return " "; })},
      {"with a byte order mark and a declaration",
       "\xef\xbb\xbf<?xml version='1.0' encoding='utf-8' standalone='yes' ?>" + xml},
      {"with comments everywhere",
       each(xml, R"((<[a-z]))", [](const auto& m) { return "<!-- < & \" -->" + m[1].str(); })},
  };
}

TEST(XmlNotation, DoesNotAffectTheCell) {
  std::set<std::string> changed;
  for (const char* file : {"everything.xml", "peers.xml", "cell.xml", "template.xml"}) {
    std::string xml =
        each(content_of(kGood + file), R"(<!--[^]*?-->|<\?[^]*?\?>)", [](const auto&) { return ""; });
    xml.erase(0, xml.find('<'));
    const std::string plain = cell_text(xml);
    ASSERT_EQ(plain, cell_text(content_of(kGood + file))) << "without its comments";
    ASSERT_EQ(plain.find("rejected"), std::string::npos) << plain;
    for (const auto& [spelling, other] : spellings(xml)) {
      if (other != xml) changed.insert(spelling);
      EXPECT_EQ(cell_text(other), plain) << file << ", " << spelling << ":\n" << other;
    }
  }
  EXPECT_EQ(changed.size(), spellings("").size());
}

// The parser applies its rules to the character that a reference stands for, not to the reference itself.
TEST(XmlNotation, CannotBypassTheRulesByCharacterReferences) {
  const std::string device =
      "<device "
      "name='d'><module><filename>a.so</filename><moduletype>thread</moduletype><operationtype>periodic"
      "</operationtype><period>1000000</period><priority>1</priority></module></device>";
  const auto with = [&](const std::string& connection) {
    return cell_text("<cell name='c'>" + device + "<connection " + connection + "/></cell>");
  };
  EXPECT_EQ(with("from='d.a.o' topic='rt&#47;x'").find("rejected"), std::string::npos);
  for (const char* wrong :
       {"from='d.a.o' topic='takt&#47;x'", "from='d.a.o' topic='&#x74;akt/x'", "from='d.a.o' topic='a&#32;b'",
        "from='d.a.o' topic='a&#10;b'", "from='d.a.o' topic='a&#9;b'", "from='d.a.o' topic='&#228;'",
        "from='d&#46;a.o' topic=''", "from='d.a&#46;' topic='t'", "from='d.a.o&#46;p' topic='t'"}) {
    EXPECT_EQ(with(wrong).rfind("rejected", 0), 0U) << wrong;
  }
  EXPECT_EQ(cell_text("<cell name='c' discovery='peers' peers='a&#32;a'>" + device + "</cell>")
                .rfind("rejected", 0),
            0U);
  EXPECT_EQ(cell_text("<cell name='c&#46;d'>" + device + "</cell>").rfind("rejected", 0), 0U);
}

TEST(XmlNotation, AllowsConnectionsBeforeDevices) {
  const std::string xml = content_of(kGood + "everything.xml");
  const std::size_t first = xml.find("  <device");
  const std::size_t connections = xml.find("  <connection");
  const std::size_t end = xml.find("</cell>");
  const std::string turned = xml.substr(0, first) + xml.substr(connections, end - connections) +
                             xml.substr(first, connections - first) + xml.substr(end);
  EXPECT_EQ(cell_text(turned), cell_text(xml));
}

}  // namespace
}  // namespace takt::descriptor::spelling_test
