#include <takt/descriptor/descriptor.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "read_cell.hpp"
#include "well_formed.hpp"

namespace takt::descriptor::descriptor_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string module(const std::string& name, const std::string& rest = "") {
  return "<module><filename>" + name +
         ".so</filename><moduletype>thread</moduletype><operationtype>periodic</operationtype>"
         "<period>1000000</period><priority>1</priority>" +
         rest + "</module>\n";
}

Problems problems_of(const std::string& xml) {
  const auto cell = parse(xml, "f.xml");
  return cell ? Problems{} : cell.problems();
}

std::vector<std::string> texts_of(const std::string& xml) {
  std::vector<std::string> texts;
  for (const Problem& problem : problems_of(xml)) texts.push_back(to_text(problem));
  return texts;
}

TEST(Descriptor, ReportsAllMistakesAtOnce) {
  const std::string xml = R"(<cell name="c" domain="900">
  <device name="robot">
    <executor name="fast" priority="100"/>
    <module>
      <filename>a.so</filename>
      <moduletype>tread</moduletype>
      <operationtype>periodic</operationtype>
      <perod>1000</perod>
      <priority>x</priority>
      <budget>0</budget>
      <executor>fsat</executor>
    </module>
    <module>
      <name>a.b</name>
      <moduletype>process</moduletype>
      <operationtype>sporadic</operationtype>
      <period>5000</period>
      <recovery atempts="3" then="stop"/>
    </module>
  </device>
  <connection from="robt.a.out" to="robot.c.in" depth="3"/>
</cell>)";
  EXPECT_THAT(
      texts_of(xml),
      ElementsAre(
          HasSubstr("f.xml:1: error: attribute 'domain' is out of range: '900'"),
          HasSubstr("f.xml:3: error: attribute 'priority' is out of range: '100'"),
          HasSubstr("f.xml:6: error: unknown value 'tread' of <moduletype>; did you mean thread?"),
          HasSubstr("f.xml:8: error: unknown element <perod> in <module>; did you mean <period>?"),
          HasSubstr("f.xml:9: error: <priority> is not a whole number: 'x'"),
          HasSubstr("f.xml:10: error: <budget> is out of range: '0'"),
          HasSubstr("f.xml:11: error: unknown executor 'fsat' of module 'a'; did you mean fast?"),
          HasSubstr("f.xml:13: error: a module has no <filename>"),
          HasSubstr("f.xml:13: error: sporadic module 'a.b' has no <priority>"),
          HasSubstr("f.xml:13: error: sporadic module 'a.b' has no <deadline>"),
          HasSubstr("f.xml:14: error: 'a.b' is not a valid module name"),
          HasSubstr("f.xml:17: error: sporadic module 'a.b' has a <period>"),
          HasSubstr("f.xml:18: error: unknown attribute 'atempts' of <recovery>; did you mean attempts?"),
          HasSubstr("f.xml:18: error: unknown value 'stop' of attribute 'then'"),
          HasSubstr("f.xml:21: error: a connection of kind latest has a depth"),
          HasSubstr(
              "f.xml:21: error: attribute 'from' names the unknown device 'robt'; did you mean robot?")));
}

TEST(Descriptor, DoesNotReportErrorsCausedByAnotherError) {
  // The executor, the module and the device exist, but the parser could not read their names.
  EXPECT_THAT(
      texts_of("<root><executor nam=\"fast\"/>" + module("a", "<executor>fast</executor>") + "</root>"),
      ElementsAre(HasSubstr("unknown attribute 'nam'")));
  EXPECT_THAT(texts_of("<cell name='c'><device name='d'>" + module("a") + module("a", "<nam>b</nam>") +
                       "</device>\n<connection from='d.a.x' to='d.b.x'/></cell>"),
              ElementsAre(HasSubstr("unknown element <nam>")));
  EXPECT_THAT(texts_of("<cell name='c'><device nme='d'>" + module("a") +
                       "</device><connection from='d.a.x' to='d.a.y'/></cell>"),
              ElementsAre(HasSubstr("unknown attribute 'nme'")));
  EXPECT_THAT(
      texts_of(
          "<cell name='c'><device name='d'><modul/></device><connection from='d.a.x' to='d.a.y'/></cell>"),
      ElementsAre(HasSubstr("unknown element <modul>")));
  EXPECT_THAT(texts_of("<cell name='c'><devise/></cell>"),
              ElementsAre(HasSubstr("unknown element <devise>")));
  EXPECT_THAT(texts_of("<cell name='c'><device name='d'>" + module("a") +
                       "</device><connection from='d.a.x' ot='d.a.y'/></cell>"),
              ElementsAre(HasSubstr("unknown attribute 'ot'")));
  EXPECT_THAT(texts_of("<rot/>"), ElementsAre(HasSubstr("unknown root element <rot>")));
  EXPECT_THAT(
      texts_of("<root><module><filename>a.so</filename><moduletype>thread</moduletype>"
               "<operationtype>cyclic</operationtype><deadline miss='error'>5</deadline><budget>5</budget>"
               "<dispatch>row</dispatch><interarrival>5</interarrival></module></root>"),
      ElementsAre(HasSubstr("unknown value 'cyclic'")));
}

TEST(Descriptor, DoesNotReportErrorsCausedByAnErrorInAConnection) {
  const auto of = [](const std::string& attributes) {
    return texts_of("<cell name='c'><device name='d'>" + module("a") + module("b") +
                    "</device>\n<connection " + attributes + "/></cell>");
  };
  // A misspelled attribute `from`, `to` or `topic` does not count as missing. So the parser does not report a
  // domain without a topic here.
  EXPECT_THAT(of("form='d.a.x' to='d.b.x'"), ElementsAre(HasSubstr("unknown attribute 'form'")));
  EXPECT_THAT(of("from='d.a.x' topc='t' domain='3'"), ElementsAre(HasSubstr("unknown attribute 'topc'")));
  EXPECT_THAT(of("from='d.a.x' topic='' domain='3'"), ElementsAre(HasSubstr("attribute 'topic' is empty")));
  EXPECT_THAT(of("from='d.a.x' to='d.b.x' deadlin='5' stale='error'"),
              ElementsAre(HasSubstr("unknown attribute 'deadlin'")));
  EXPECT_THAT(of("from='d.a.x' to='d.b.x' kind='cue' depth='5'"),
              ElementsAre(HasSubstr("unknown value 'cue'")));
  // The value "queue" shows that `type` is a misspelled `kind`. So the parser does not report the depth and
  // the second writer, which only a queue may have.
  EXPECT_THAT(of("from='d.a.x' to='d.b.x' type='queue' depth='5'/>"
                 "<connection from='d.a.y' to='d.b.x' kind='queue'"),
              ElementsAre(HasSubstr("unknown attribute 'type' of <connection>; did you mean kind?")));
  EXPECT_THAT(of("from='' to='d.b.x'"), ElementsAre(HasSubstr("attribute 'from' is empty")));
  EXPECT_THAT(of("from='nobody.a.x' topic='t'"),
              ElementsAre(HasSubstr("attribute 'from' names the unknown device")));
  // Two topics that the parser could not read do not count as the same topic.
  EXPECT_THAT(of("to='d.b.x' topic=''/><connection from='d.a.x' topic=''/><connection from='d.b.y' topic=''"),
              ElementsAre(HasSubstr("empty"), HasSubstr("empty"), HasSubstr("empty")));
}

TEST(Descriptor, DoesNotReportErrorsCausedByAnErrorInDiscovery) {
  const auto of = [](const std::string& attributes) {
    return texts_of("<cell name='c' " + attributes + "><device name='d'>" + module("a") + "</device></cell>");
  };
  EXPECT_THAT(of("discovery='peer' peers='10.0.0.1'"), ElementsAre(HasSubstr("did you mean peers?")));
  EXPECT_THAT(of("discovry='peers' peers='10.0.0.1'"),
              ElementsAre(HasSubstr("unknown attribute 'discovry'")));
  EXPECT_THAT(of("discovery='peers' pers='10.0.0.1'"), ElementsAre(HasSubstr("unknown attribute 'pers'")));
  EXPECT_THAT(of("discovery='server' sever='h:1'"), ElementsAre(HasSubstr("unknown attribute 'sever'")));
  EXPECT_THAT(of("discovery='server' server='h:1' server_device='d'"),
              ElementsAre(HasSubstr("did you mean server-device?")));
  EXPECT_THAT(of("discovery='peers' peers=''"), ElementsAre(HasSubstr("attribute 'peers' is empty")));
}

TEST(Descriptor, TheDefaultReliabilityDependsOnTheKindOfConnection) {
  const auto of = [](const std::string& attributes) {
    const auto cell = parse("<cell name='c'><device name='d'>" + module("a") + module("b") +
                                "</device><connection from='d.a.x' to='d.b.x' " + attributes + "/></cell>",
                            "f.xml");
    return cell ? cell->connections.at(0).reliability : throw std::runtime_error{to_text(cell.problems())};
  };
  EXPECT_EQ(of(""), model::Reliability::best_effort);
  EXPECT_EQ(of("kind='latest'"), model::Reliability::best_effort);
  EXPECT_EQ(of("kind='queue'"), model::Reliability::reliable);
  EXPECT_EQ(of("reliability='reliable'"), model::Reliability::reliable);
  EXPECT_EQ(of("reliability='best-effort' kind='queue'"), model::Reliability::best_effort);
}

TEST(Descriptor, DistinguishesADepthOfOneFromAMissingDepth) {
  const auto given = [](const std::string& attributes) {
    const auto cell =
        parse("<cell name='c'><device name='d'>" + module("a") + module("b") +
                  "</device><connection from='d.a.x' to='d.b.x' kind='queue'" + attributes + "/></cell>",
              "f.xml");
    return cell ? cell->connections.at(0).depth_given : throw std::runtime_error{to_text(cell.problems())};
  };
  EXPECT_FALSE(given(""));
  EXPECT_TRUE(given(" depth='1'"));
}

TEST(Descriptor, ReadsTimesWithAndWithoutAUnit) {
  const auto period_of = [](const std::string& text) {
    const auto cell = parse(
        "<root><module><filename>a.so</filename><moduletype>thread</moduletype><operationtype>"
        "periodic</operationtype><period>" +
            text + "</period><priority>1</priority></module></root>",
        "f.xml");
    return cell ? cell->devices[0].modules[0].period->count() : -1;
  };
  EXPECT_EQ(period_of("2000000"), 2'000'000);
  EXPECT_EQ(period_of("2000000ns"), 2'000'000);
  EXPECT_EQ(period_of("500us"), 500'000);
  EXPECT_EQ(period_of(" 2 ms "), 2'000'000);
  EXPECT_EQ(period_of("1s"), 1'000'000'000);
  EXPECT_EQ(period_of("1.25ms"), 1'250'000);
  EXPECT_EQ(period_of("0.000001000s"), 1'000);
  EXPECT_EQ(period_of("1000.000ns"), 1'000);
  EXPECT_EQ(period_of("9223372036.854775807s"), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(period_of("9223372036.854775808s"), -1);
  EXPECT_EQ(period_of("1.0000001ms"), -1);
  EXPECT_EQ(period_of("1h"), -1);
}

TEST(Descriptor, ReadsConnectionsToExternalPrograms) {
  const auto cell = parse("<cell name='c' domain='4'><device name='d'>" + module("a") +
                              "</device><connection to='d.a.in' topic='rt/in' domain='3'/>"
                              "<connection from='d.a.out' topic=' rt/out '/></cell>",
                          "f.xml");
  ASSERT_TRUE(cell) << to_text(cell.problems());
  const model::Connection& in = cell->connections.at(0);
  EXPECT_FALSE(in.from.given());
  EXPECT_TRUE(in.to.given());
  EXPECT_EQ(in.topic, "rt/in");
  EXPECT_EQ(in.domain, 3);
  const model::Connection& out = cell->connections.at(1);
  EXPECT_TRUE(out.from.given());
  EXPECT_FALSE(out.to.given());
  EXPECT_EQ(out.topic, "rt/out");
  EXPECT_FALSE(out.domain);
}

TEST(Descriptor, ReportsAtMostAThousandProblems) {
  std::string xml = "<root>";
  for (int i = 0; i < 999; ++i) xml += "<x/>\n";
  EXPECT_EQ(problems_of(xml + module("a") + "</root>").size(), 999U);
  for (int i = 0; i < 100; ++i) xml += "<x/>\n";
  const Problems problems = problems_of(xml + module("a") + "</root>");
  ASSERT_EQ(problems.size(), 1000U);
  EXPECT_THAT(problems.back().what, HasSubstr("too many problems"));

  std::string values;
  for (int i = 0; i < 2000; ++i) values += "<value/>";
  EXPECT_EQ(problems_of("<root>" + module("a", "<property>" + values + "</property>") + "</root>").size(),
            1000U);
}

TEST(Descriptor, ReportsALongInvalidValueShortenedToOneLine) {
  const auto texts = texts_of(
      "<root>" + module("a", "<executor>" + std::string(100000, 'x') + "\n&#x85;</executor>") + "</root>");
  ASSERT_EQ(texts.size(), 1U);
  EXPECT_LT(texts[0].size(), 400U);
  EXPECT_EQ(texts[0].find('\n'), std::string::npos);
  EXPECT_THAT(texts[0], HasSubstr("...xxx"));
}

// tinyxml2 itself drops white space that is the only text between two pieces of markup. The parser must keep
// this white space.
TEST(Descriptor, KeepsTheWhiteSpaceOfPropertyValues) {
  const auto cell = parse(
      "<root>" +
          module("a", "<property><value name=' x '> 5 &lt;<!-- - --><![CDATA[&]]>\n</value></property>") +
          "</root>",
      "f.xml");
  ASSERT_TRUE(cell) << to_text(cell.problems());
  const auto& property = cell->devices[0].modules[0].properties.at(0);
  EXPECT_EQ(property.name, "x");
  EXPECT_EQ(property.value, " 5 <&");
}

TEST(Descriptor, AcceptsAByteOrderMark) {
  EXPECT_TRUE(parse("\xef\xbb\xbf<root>" + module("a") + "</root>", "f.xml"));
}

TEST(Descriptor, ReportsTheLineOfAProblemEvenWithoutAFile) {
  const auto cell = parse("<root>\n<x/>" + module("a") + "</root>", "");
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.problems()[0].where, "line 2");
}

TEST(Descriptor, NamesTheCellAfterItsFile) {
  EXPECT_EQ(name_after("deploy/module.xml"), "module");
  EXPECT_EQ(name_after("my cell (2).xml"), "my_cell__2_");
  EXPECT_EQ(name_after("7.xml"), "_");
  EXPECT_EQ(name_after("a-7.b.xml"), "a-7_b");
  EXPECT_EQ(name_after(""), "cell");
  EXPECT_EQ(name_after(std::string(100, 'x') + ".xml").size(), model::kMaxNameLength);
  EXPECT_TRUE(model::is_valid_name(name_after("\xff\n\xc3\xa9")));
}

TEST(DescriptorText, RejectsMalformedXmlWithItsLine) {
  const std::vector<std::pair<std::string, std::pair<int, std::string>>> faults{
      {"", {1, "the file is empty"}},
      {"\n\n", {1, "the file is empty"}},
      {"<!-- x -->\n", {2, "the file has no root element"}},
      {"<root>\n\xff</root>", {2, "not UTF-8: it has the byte '\\xff'"}},
      {"<root>\n\n\xed\xa0\x80</root>", {3, "not UTF-8"}},
      {"\xff\xfe<", {1, "UTF-16"}},
      {"\x7f"
       "ELF\x02\x01\x01",
       {1, "the file is a program or a shared object, not a descriptor; give the path of an XML"}},
      {"\n#include <x>\nint y;",
       {2, "the file is not XML: it begins with '#include'; give the path of a descriptor"}},
      {"cell: c\n  device: d\n", {1, "the file is not XML: it begins with 'cell: c'; give the path of"}},
      {std::string("<root>\n\0</root>", 15), {2, "a zero byte"}},
      {"<root>\n\x1b</root>", {2, "a control character '\\x1b'"}},
      {"<?xml version=\"1.0\" encoding=\"latin1\"?><root/>", {1, "encoding 'latin1'"}},
      {"<?xml version=\"1.1\"?><root/>", {1, "XML version '1.1'"}},
      {"\n<?xml version=\"1.0\"?><root/>", {2, "a processing instruction"}},
      {"<root>\n&#0;</root>", {2, "'&#0;' is not a character"}},
      {"<root>\n&#xD800;</root>", {2, "is not a character"}},
      {"<root>\n&#99999999999999;</root>", {2, "is not a character"}},
      {"<root>\n&#X41;</root>", {2, "is not a character"}},
      {"<root>\n]]></root>", {2, "]]> in a text"}},
      {"<root>\n<!-- a\nb", {2, "a comment is not closed"}},
      {"<root>\n<!-- a\n -- b --></root>", {3, "-- inside a comment"}},
      {"<root>\n<![CDATA[ </root>", {2, "a CDATA section is not closed"}},
      {"<root>\n<module\n", {2, "the tag <module is not closed"}},
      {"<root>\n</rot>", {2, "</rot> does not close <root> of line 1"}},
      {"<root/>\n</root>", {2, "</root> closes nothing"}},
      {"<root a=\"1\"\n a=\"2\"/>", {2, "duplicate attribute 'a'"}},
      {"<root a=\"1\"b=\"2\"/>", {1, "found 'b' in the tag <root"}},
      {"<root a='1\n<module/>'/>", {1, "does not end, or contains a <"}},
  };
  for (const auto& [xml, expected] : faults) {
    const auto texts = texts_of(xml);
    ASSERT_EQ(texts.size(), 1U) << xml;
    EXPECT_THAT(texts[0], testing::StartsWith("f.xml:" + std::to_string(expected.first) + ": error: "));
    EXPECT_THAT(texts[0], HasSubstr(expected.second));
  }
}

TEST(DescriptorText, RejectsDeepNesting) {
  const auto nested = [](std::size_t depth) {
    std::string xml;
    for (std::size_t i = 0; i < depth; ++i) xml += "<root>\n";
    for (std::size_t i = 0; i < depth; ++i) xml += "</root>";
    return xml;
  };
  EXPECT_FALSE(find_syntax_error(nested(kMaxDepth)));
  const auto fault = find_syntax_error(nested(kMaxDepth + 1));
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->line, static_cast<int>(kMaxDepth) + 1);
  EXPECT_THAT(fault->what, HasSubstr("nested"));
  EXPECT_TRUE(find_syntax_error(nested(1'000'000)));
}

TEST(DescriptorText, RejectsTextThatIsTooLarge) {
  EXPECT_THAT(texts_of(std::string(kMaxBytes + 1, ' ')),
              ElementsAre(HasSubstr("f.xml:1: error: the file is larger than 16 MiB")));
  EXPECT_THAT(texts_of(std::string(kMaxBytes, ' ')), ElementsAre(HasSubstr("the file is empty")));
}

TEST(DescriptorFile, RejectsAFileThatCannotBeRead) {
  for (const std::string file : {"/nowhere/module.xml", "/tmp", ""}) {
    const auto cell = load(file);
    ASSERT_FALSE(cell) << file;
    EXPECT_EQ(cell.problems()[0].where, file) << "the location has no line number";
    EXPECT_THAT(cell.problems()[0].what, HasSubstr("cannot be read"));
    EXPECT_FALSE(cell.problems()[0].fix.empty());
  }
}

TEST(DescriptorFile, RejectsAFileThatNeverEnds) {
  const auto cell = load("/dev/zero");
  ASSERT_FALSE(cell);
  EXPECT_THAT(cell.problems()[0].what, HasSubstr("larger than"));
}

TEST(DescriptorFile, ReportsAnEmptyFile) {
  const auto file = std::filesystem::temp_directory_path() / "takt_descriptor_test_empty.xml";
  std::ofstream{file};
  const auto cell = load(file.string());
  std::filesystem::remove(file);
  ASSERT_FALSE(cell);
  EXPECT_THAT(cell.problems()[0].what, HasSubstr("the file is empty"));
}

}  // namespace
}  // namespace takt::descriptor::descriptor_test
