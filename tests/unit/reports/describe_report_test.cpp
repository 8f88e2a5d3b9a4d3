#include "reports/describe_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sstream>

#include "reports/page.hpp"

namespace takt::tool::describe_report_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

model::Port port(const std::string& name, model::Direction direction, const std::string& text = {}) {
  model::Type type{"line::Part", {{.name = "number", .scalar = model::Scalar::uint32}}};
  type.fields.push_back({.name = "at", .scalar = model::Scalar::float64, .unit = "m", .dimensions = {3}});
  return {name, direction, type, text};
}

host::PropertyDescription speed() {
  return {"speed", "double", "0.5", "0 to 2", "0", "2", "m/s", "Of the belt."};
}

Described belt() {
  return {"/c/belt.so",
          "3fa91c02",
          {.name = "Belt",
           .text = "Moves parts & <waits>.",
           .version = "1.2.0",
           .interface = "c++",
           .operation = {},
           .hooks = {},
           .properties = {speed(), {"label", "string", "", "", "", "", "", ""}},
           .ports = {port("stop", model::Direction::in, "Whether to stop."),
                     port("part", model::Direction::out)}}};
}

Described in_a_cell() {
  Described described = belt();
  described.cell = "plant";
  described.device = "line";
  described.module = model::Module{};
  described.module->name = "first";
  described.module->operation = model::Operation::sporadic;
  described.module->properties = {{.name = "speed", .value = "1.25"}};
  return described;
}

std::size_t longest_line(const std::string& text) {
  std::size_t longest = 0;
  std::istringstream lines{text};
  for (std::string line; std::getline(lines, line);) longest = std::max(longest, line.size());
  return longest;
}

TEST(DescribeReport, ShowsAllPartsOfAComponent) {
  EXPECT_EQ(describe_text(belt(), {}),
            "Belt: Moves parts & <waits>.\n"
            "  file        /c/belt.so\n"
            "  version     1.2.0, hash 3fa91c02\n"
            "  interface   c++\n"
            "  properties\n"
            "    name   type    default  range   unit\n"
            "    speed  double  0.5      0 to 2  m/s   Of the belt.\n"
            "    label  string  ''\n"
            "  ports\n"
            "    in     stop  line::Part\n"
            "           Whether to stop.\n"
            "           unsigned long number, double[3] at (m)\n"
            "    out    part  line::Part\n"
            "           unsigned long number, double[3] at (m)\n");
}

TEST(DescribeReport, ListsTheEnumeratorsOfATypeOnlyOnce) {
  Described described = belt();
  const model::Field mode{.name = "mode",
                          .scalar = model::Scalar::enumeration,
                          .type_name = "line::Mode",
                          .enumerators = {"STANDS", "RUNS"}};
  described.component.ports[1].type.fields = {mode, mode};
  EXPECT_THAT(describe_text(described, {}), HasSubstr("           line::Mode mode, line::Mode mode\n"
                                                      "           line::Mode: STANDS, RUNS\n"));
  EXPECT_THAT(describe_text(described, {}), Not(HasSubstr("RUNS\n           line::Mode:")));
}

TEST(DescribeReport, WrapsLongSentencesToTheWidthOfTheTerminal) {
  Described described = belt();
  for (int i = 0; i < 30; ++i) described.component.properties[0].text += "word and word ";
  described.component.ports[0].text = described.component.properties[0].text;
  for (int i = 0; i < 40; ++i)
    described.component.ports[0].type.fields.push_back({.name = "x" + std::to_string(i)});
  const std::string text = describe_text(described, {});
  EXPECT_LE(longest_line(text), 100U) << text;
  EXPECT_THAT(text, HasSubstr("\n                                          and word word"));
}

TEST(DescribeReport, ShowsThePropertyValuesOfTheDescriptor) {
  const std::string text = describe_text(in_a_cell(), {});
  EXPECT_THAT(text, AllOf(HasSubstr("line.first: Moves"), HasSubstr("default  given  range"),
                          HasSubstr("0.5      1.25   0 to 2"), HasSubstr("sporadic")));
}

TEST(DescribeReport, SaysThatAProgramWithoutDeclaredPropertiesAcceptsAny) {
  Described described{"/c/p.exe", "", {.name = "p", .interface = "process"}};
  EXPECT_THAT(describe_text(described, {}),
              AllOf(HasSubstr("any name; each becomes an argument"), HasSubstr("ports       none")));
  described.component.properties.push_back(speed());
  EXPECT_THAT(describe_text(described, {}), Not(HasSubstr("any name")));
}

TEST(DescribeReport, PrintsOneJsonObjectPerLine) {
  const std::string text = describe_json(in_a_cell());
  EXPECT_EQ(text.find('\n'), text.size() - 1);
  const auto object = nlohmann::json::parse(text);
  EXPECT_EQ(object["properties"][0]["min"], 0);
  EXPECT_EQ(object["properties"][0]["range"], "0 to 2");
  EXPECT_TRUE(object["properties"][1]["max"].is_null());
  EXPECT_EQ(object["module"]["given"]["speed"], "1.25");
  EXPECT_EQ(object["ports"][1]["direction"], "out");
  EXPECT_EQ(object["version"], "1.2.0");
  EXPECT_EQ(object["hash"], "3fa91c02");
}

TEST(Page, LetsNoTextBeginALine) {
  Page page{{}};
  page.line(0, "a\nb");
  page.sentence(0, "a\nb");
  page.words(0, "", {"a\nb"});
  page.heading(0, "a\nb", "c");
  page.table(0, {{"name"}, {"a\nb"}});
  EXPECT_EQ(std::move(page).take(), "a\\nb\na\\nb\na\\nb\na\\nb: c\nname\na\\nb\n");
}

TEST(DescribeReport, EscapesControlCharactersOfAComponent) {
  const std::string odd = "a\x1b[31m\u009b\u202e\nb";
  Described described = belt();
  described.path = "/c/" + odd;
  described.component.name = odd;
  described.component.properties = {{"label", "string", odd, odd, "", "", odd, odd},
                                    {"direction", "string", "c\u202e\u009b\rd\ne", "", "", "", "", ""}};
  described.component.ports[0].text = odd;
  const std::string escaped = R"(a\x1b[31m\xc2\x9b\xe2\x80\xae\nb)";
  for (const std::string& text :
       {describe_text(described, {}), component_list_text({{odd, "c++", odd}}, {})}) {
    EXPECT_THAT(text, HasSubstr(escaped));
    EXPECT_THAT(text, Not(testing::ContainsRegex("[\x1b\r\u009b\u202e]|\nb")));
  }
  for (const std::string& xml : {describe_xml(described), iso22166_profile(described, std::nullopt)}) {
    EXPECT_THAT(xml, HasSubstr("c&#x202e;&#x9b;&#xd;d\ne"));
    EXPECT_THAT(xml, Not(testing::ContainsRegex("[\x1b\r\u009b\u202e]")));
  }
  EXPECT_THAT(describe_xml(described), Not(HasSubstr("name=\"label\""))) << "XML cannot express its default";
}

TEST(DescribeReport, ProposesTheOperationTypeThatAProgramUses) {
  Described described{"/c/p.exe", "", {.name = "p", .text = "A -- b --- c", .interface = "process"}};
  EXPECT_THAT(describe_xml(described),
              AllOf(HasSubstr("<operationtype>periodic<"), HasSubstr("<!-- A - b - c -->")));
  described.component.operation = "sporadic";
  EXPECT_THAT(describe_xml(described), AllOf(HasSubstr("<operationtype>sporadic<"), HasSubstr("<deadline>"),
                                             Not(HasSubstr("<dispatch>"))));
  described.component.operation = "non-real";
  EXPECT_THAT(describe_xml(described), AllOf(HasSubstr("<operationtype>non-real<"),
                                             Not(HasSubstr("<period>")), Not(HasSubstr("<priority>"))));
}

TEST(Iso22166Profile, IsTheExpectedXmlForAComponent) {
  EXPECT_EQ(iso22166_profile(belt(), std::nullopt),
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
            "<module>\n"
            "  <generalInfo>\n"
            "    <moduleName>Belt</moduleName>\n"
            "    <description>Moves parts &amp; &lt;waits&gt;.</description>\n"
            "  </generalInfo>\n"
            "  <properties>\n"
            "    <property>\n"
            "      <name>speed</name>\n"
            "      <type>double</type>\n"
            "      <value>0.5</value>\n"
            "      <unit>m/s</unit>\n"
            "      <description>Of the belt.</description>\n"
            "    </property>\n"
            "    <property>\n"
            "      <name>label</name>\n"
            "      <type>string</type>\n"
            "    </property>\n"
            "  </properties>\n"
            "  <ioVariables>\n"
            "    <inputs>\n"
            "      <input>\n"
            "        <name>stop</name>\n"
            "        <type>line::Part</type>\n"
            "        <description>Whether to stop.</description>\n"
            "      </input>\n"
            "    </inputs>\n"
            "    <outputs>\n"
            "      <output>\n"
            "        <name>part</name>\n"
            "        <type>line::Part</type>\n"
            "      </output>\n"
            "    </outputs>\n"
            "  </ioVariables>\n"
            "</module>\n");
}

TEST(Iso22166Profile, TakesPropertyValuesAndExecutionTypeFromTheDescriptor) {
  const Described described = in_a_cell();
  EXPECT_THAT(iso22166_profile(described, operation_of(described)),
              AllOf(HasSubstr("<exeType>EVENTDRIVEN</exeType>"), HasSubstr("<value>1.25</value>")));
  EXPECT_THAT(iso22166_profile(belt(), model::Operation::periodic), HasSubstr("<exeType>PERIODIC</exeType>"));
  EXPECT_THAT(iso22166_profile(belt(), model::Operation::non_real), HasSubstr("<exeType>NONRT</exeType>"));
}

TEST(ComponentList, IsGroupedByFolder) {
  const std::vector<host::ComponentFile> files{
      {"/a/belt.so", "c++", "Moves parts."}, {"/a/counter.exe", "process", ""}, {"/b/x.so", "c", "Does."}};
  EXPECT_EQ(component_list_text(files, {}),
            "/a\n"
            "  belt.so      c++      Moves parts.\n"
            "  counter.exe  process\n"
            "\n"
            "/b\n"
            "  x.so  c  Does.\n");
  EXPECT_EQ(nlohmann::json::parse(component_list_json(files))["components"][2]["file"], "x.so");
}

}  // namespace
}  // namespace takt::tool::describe_report_test
