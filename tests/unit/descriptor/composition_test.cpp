// Tests includes and templates. A descriptor with them must give the same cell as one without them, problems
// must name the lines of the template and of its use, and the parser must reject unbounded growth.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <folders.hpp>
#include <takt/descriptor/descriptor.hpp>
#include "bundle.hpp"
#include "include.hpp"
#include "parameters.hpp"
#include "write.hpp"

#include "cell_text.hpp"

namespace takt::descriptor::composition_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kCases = source_path("tests/unit/descriptor/cases/");

std::string cell_text(const Result<model::Cell>& cell) {
  return cell ? text_of_cell(*cell) : "rejected: " + to_text(cell.problems());
}

std::vector<std::string> texts_of(const Result<model::Cell>& cell) {
  std::vector<std::string> texts;
  if (cell) return texts;
  for (const Problem& problem : cell.problems()) texts.push_back(to_text(problem));
  return texts;
}

/// A temporary folder for the files of a test.
class Folder {
 public:
  Folder()
      : path_(fs::temp_directory_path() /
              ("takt_composition_test_" + std::to_string(std::random_device{}()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string write(const std::string& name, const std::string& text) const {
    fs::create_directories((path_ / name).parent_path());
    std::ofstream{path_ / name} << text;
    return file(name);
  }
  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
};

std::string module(const std::string& name, const std::string& period, const std::string& gain) {
  return "<module>" + (name.empty() ? "" : "<name>" + name + "</name>") +
         "<filename>a.so</filename><moduletype>thread</moduletype><operationtype>periodic</"
         "operationtype><period>" +
         period + "</period><priority>1</priority><property><value name='gain'>" + gain +
         "</value></property></module>\n";
}

// Builds random cells of similar axes, each with a template and without one, and compares the two cells.
TEST(Composition, ProducesTheSameCellAsADescriptorWithoutTemplates) {
  std::mt19937 random{1};
  const auto draw = [&random](int most) {
    return static_cast<int>(random() % static_cast<unsigned>(most)) + 1;
  };
  for (int round = 0; round < 200; ++round) {
    std::string uses;
    std::string modules;
    std::string inner_connections;
    std::string by_use;
    std::string by_hand;
    const int axes = draw(5);
    for (int i = 1; i <= axes; ++i) {
      const std::string name = "axis" + std::to_string(i);
      const std::string period = std::to_string(1000 * draw(50));
      const bool given = draw(2) == 1;
      const std::string gain = given ? std::to_string(draw(100)) + " $${x &lt; &amp; $" : "1.0";
      uses += "<use template='axis' name='" + name + "'><set name='period'>" + period + "</set>" +
              (given ? "<set name='gain'>" + gain + "</set>" : "") + "</use>\n";
      modules += module(name + "_servo", period, gain + " of " + name) + module(name + "_drive", period, "2");
      inner_connections += "<connection from='d." + name + "_servo.effort' to='d." + name +
                           "_drive.effort' kind='queue' depth='4'/>\n";
      by_use += "<connection from='d.plan.out' to='d." + name + ".setpoint'/>\n";
      by_hand += "<connection from='d.plan.out' to='d." + name + "_servo.in'/>\n";
    }
    const std::string used =
        "<cell name='c'><template name='axis'><parameter name='gain' default='1.0'/>"
        "<parameter name='period'/>" +
        module("servo", "${period}", "${gain} of ${name}") + module("drive", "${period}", "2") +
        "<connection from='servo.effort' to='drive.effort' kind='queue' depth='4'/>"
        "<export port='setpoint' of='servo.in'/></template><device name='d'>" +
        module("plan", "1000", "0") + uses + "</device>" + by_use + "</cell>";
    const auto written = parse("<cell name='c'><device name='d'>" + module("plan", "1000", "0") + modules +
                                   "</device>" + by_hand + inner_connections + "</cell>",
                               "f.xml");
    ASSERT_TRUE(written) << to_text(written.problems());
    ASSERT_EQ(cell_text(parse(used, "f.xml")), cell_text(written)) << used;
  }
}

TEST(Composition, PrefixesNamesInATemplateWithTheNamesOfItsUses) {
  const auto cell = load(kCases + "good/template_composite.xml");
  ASSERT_TRUE(cell) << to_text(cell.problems());
  std::vector<std::string> names;
  for (const auto& module : cell->devices[0].modules) names.push_back(module.name);
  EXPECT_THAT(names, ElementsAre("plan", "a_left_servo", "a_left_drive", "a_right_servo", "a_right_drive",
                                 "b_left_servo", "b_left_drive", "b_right_servo", "b_right_drive"));
  std::vector<std::string> connections;
  for (const auto& c : cell->connections)
    connections.push_back(to_text(c.from) + " " + to_text(c.to) + " " + c.topic);
  EXPECT_THAT(connections, testing::Contains("d.plan.out d.a_left_servo.setpoint "));
  EXPECT_THAT(connections, testing::Contains("d.a_left_drive.state d.a_right_drive.state "));
  EXPECT_THAT(connections, testing::Contains("d.b_right_drive.state e.log.in rt/b"));
}

TEST(Composition, InsertsTheContentsOfIncludedFiles) {
  const auto cell = load(kCases + "good/include.xml");
  ASSERT_TRUE(cell) << to_text(cell.problems());
  ASSERT_EQ(cell->devices.size(), 2U);
  for (const auto& device : cell->devices) {
    EXPECT_EQ(device.executors[0].name, "fast");
    ASSERT_EQ(device.modules.size(), 2U);
    EXPECT_EQ(device.modules[1].name, "axis1");
  }
}

// Each valid descriptor must give the same cell after flatten(), and after it is sent as a bundle (one text
// with all included files).
TEST(Composition, FlattenedAndBundledDescriptorsGiveTheSameCell) {
  int files = 0;
  for (const auto& entry : fs::directory_iterator{kCases + "good"}) {
    SCOPED_TRACE(entry.path().string());
    std::string sent;
    const auto cell = load(entry.path().string(), &sent);
    const auto flat = flatten(entry.path().string());
    ASSERT_TRUE(cell && flat);
    ++files;
    for (const char* gone : {"<include", "<template", "<use", "<parameter"})
      EXPECT_EQ(flat->find(gone), std::string::npos) << *flat;
    EXPECT_EQ(cell_text(parse(*flat, entry.path().string())), cell_text(cell)) << *flat;
    EXPECT_EQ(cell_text(parse(sent, entry.path().string())), cell_text(cell)) << sent;
  }
  EXPECT_GE(files, 40);
}

TEST(Composition, ReportsTheLinesOfATemplateAndOfItsUse) {
  const Folder folder;
  folder.write("lib/parts.xml", "<fragment>\n<template name='axis'>\n<parameter name='executor'/>\n" +
                                    module("", "1000", "1") +
                                    "</template>\n<template name='pair'>\n<use template='axis' name='l'>"
                                    "<set name='executor'/></use></template></fragment>");
  const std::string cell =
      folder.write("cell.xml",
                   "<cell name='c'>\n<include file='lib/parts.xml'/>\n<device name='d'>\n"
                   "<use template='pair' name='a'/>\n<use template='pair' name='b'/>\n</device></cell>");
  const std::string parts_file = folder.file("lib/parts.xml");
  // A problem in the template itself: the report names only the line in the template.
  EXPECT_THAT(
      texts_of(load(cell)),
      ElementsAre(HasSubstr(parts_file +
                            ":3: error: parameter 'executor' of template 'axis' is not used (included at " +
                            cell + ":2); ")));
  folder.write(
      "lib/parts.xml",
      "<fragment>\n<template name='axis'>\n" + module("", "0", "1") +
          "</template>\n<template name='pair'>\n<use template='axis' name='l'/></template></fragment>");
  EXPECT_THAT(texts_of(load(cell)),
              ElementsAre(HasSubstr(parts_file + ":3: error: <period> is out of range: '0' (used at " +
                                    parts_file + ":6, used at " + cell + ":4, and 1 more); ")));
  // Checks that run after the templates are expanded must name the line in the template and the line of the
  // use. In this case, the executor does not exist.
  std::string named = module("", "1000", "1");
  named.insert(named.find("<period>"), "<executor>fast</executor>");
  folder.write(
      "lib/parts.xml",
      "<fragment>\n<template name='axis'>\n" + named +
          "</template>\n<template name='pair'>\n<use template='axis' name='l'/></template></fragment>");
  EXPECT_THAT(
      texts_of(load(cell)),
      ElementsAre(HasSubstr(parts_file + ":3: error: unknown executor 'fast' of module 'a_l' (used at " +
                            parts_file + ":6, used at " + cell + ":4); "),
                  HasSubstr("of module 'b_l' (used at " + parts_file + ":6, used at " + cell + ":5); ")));
}

TEST(Composition, RejectsStrayTextInAFragment) {
  const Folder folder;
  folder.write("parts.xml", "<fragment>\nstray words\n</fragment>");
  const std::string cell =
      folder.write("cell.xml", "<cell name='c'>\n<include file='parts.xml'/>\n<device name='d'>" +
                                   module("m", "1000", "1") + "</device></cell>");
  EXPECT_THAT(texts_of(load(cell)),
              ElementsAre(HasSubstr(folder.file("parts.xml") +
                                    ":2: error: text 'stray words' in <cell> (included at " + cell +
                                    ":2); remove it")));
}

// A node gets only the bundle, without the files. The node must report the same problems as a parser that
// reads the files.
TEST(Composition, ReportsTheSameProblemsForABundleAsForFiles) {
  const Folder folder;
  const std::string right =
      "<fragment><template name='axis'>\n" + module("", "1000", "1") + "</template></fragment>";
  folder.write("parts.xml", right);
  const std::string cell = folder.write("cell.xml",
                                        "<cell name='c'>\n<include file='./parts.xml'/>\n<device "
                                        "name='d'>\n<use template='axis' name='a'/></device></cell>");
  std::string sent;
  ASSERT_TRUE(load(cell, &sent));
  fs::remove(folder.file("parts.xml"));
  ASSERT_TRUE(parse(sent, "cell.xml")) << "parse() must not open a file";
  EXPECT_THAT(texts_of(load(cell)), ElementsAre(HasSubstr(cell + ":2: error: the included file")));
  EXPECT_THAT(
      texts_of(parse("<cell name='c'>\n<include file='" + kCases + "included/devices.xml'/></cell>", "net")),
      ElementsAre(HasSubstr("net:2: error: the included file")));

  std::string wrong = sent;
  wrong.replace(wrong.find("1000&lt;"), 4, "none");
  EXPECT_THAT(
      texts_of(parse(wrong, "cell.xml")),
      ElementsAre(HasSubstr(folder.file("parts.xml") +
                            ":2: error: <period> is not a time: 'none' (used at " + cell + ":4); ")));
}

TEST(Composition, RejectsCircularAndTooManyIncludes) {
  const Folder folder;
  const std::string device = "<device name='d'>" + module("", "1000", "1") + "</device></cell>";
  const std::string cell = folder.write("cell.xml", "<cell name='c'>\n<include file='a.xml'/>" + device);
  folder.write("a.xml", "<fragment>\n\n<include file='b.xml'/></fragment>");
  folder.write("b.xml", "<fragment>\n<include file='../" +
                            fs::path{folder.file("")}.parent_path().filename().string() +
                            "/a.xml'/></fragment>");
  EXPECT_THAT(texts_of(load(cell)), ElementsAre(HasSubstr(folder.file("b.xml") + ":2: error: ")));
  EXPECT_THAT(texts_of(load(cell)), ElementsAre(HasSubstr("includes itself")));
  EXPECT_THAT(texts_of(load(cell)), ElementsAre(HasSubstr("(included at " + folder.file("a.xml") +
                                                          ":3, included at " + cell + ":2)")));

  std::size_t depth = 0;
  for (; depth < kMaxIncludeDepth; ++depth)
    folder.write("f" + std::to_string(depth) + ".xml",
                 "<fragment><include file='f" + std::to_string(depth + 1) + ".xml'/></fragment>");
  folder.write("f" + std::to_string(depth) + ".xml", "<fragment/>");
  EXPECT_TRUE(load(folder.write("cell.xml", "<cell name='c'><include file='f1.xml'/>" + device)));
  EXPECT_THAT(texts_of(load(folder.write("cell.xml", "<cell name='c'><include file='f0.xml'/>" + device))),
              ElementsAre(HasSubstr("more than 8 levels deep")));

  std::string many;
  for (std::size_t i = 0; i < kMaxIncludes; ++i) many += "<include file='f8.xml'/>\n";
  EXPECT_TRUE(load(folder.write("cell.xml", "<cell name='c'>" + many + device)));
  EXPECT_THAT(texts_of(load(folder.write("cell.xml", "<cell name='c'>" + many + many + device))),
              ElementsAre(HasSubstr("more than 1000 files are included")));

  folder.write("large.xml", "<fragment><!--" + std::string(kMaxBytes / 4, 'x') + "--></fragment>");
  const std::string large = "<include file='large.xml'/>\n";
  EXPECT_TRUE(load(folder.write("cell.xml", "<cell name='c'>" + large + large + large + device)));
  EXPECT_THAT(
      texts_of(load(folder.write("cell.xml", "<cell name='c'>" + large + large + large + large + device))),
      ElementsAre(HasSubstr("larger than 16 MiB")));
}

TEST(Composition, RejectsTemplatesThatExpandToTooManyElements) {
  std::string templates = "<template name='t0'>" + module("", "1000", "1") + "</template>\n";
  for (int i = 1; i < 8; ++i) {
    templates += "<template name='t" + std::to_string(i) + "'>";
    for (int k = 0; k < 300; ++k)
      templates += "<use template='t" + std::to_string(i - 1) + "' name='u" + std::to_string(k) + "'/>";
    templates += "</template>\n";
  }
  EXPECT_THAT(texts_of(parse("<cell name='c'>" + templates +
                                 "<device name='d'><use template='t7' name='x'/></device></cell>",
                             "f.xml")),
              ElementsAre(HasSubstr("alone makes more than 10^18 elements")));

  // Even a few elements can get huge values: here, each template passes its parameter on, repeated twenty
  // times.
  std::string twenty;
  for (int i = 0; i < 20; ++i) twenty += "${v}";
  std::string values =
      "<template name='t0'><parameter name='v'/>" + module("", "1000", "${v}") + "</template>\n";
  for (int i = 1; i < 8; ++i) {
    values += "<template name='t" + std::to_string(i) + "'><parameter name='v'/><use template='t" +
              std::to_string(i - 1) + "' name='u'><set name='v'>" + twenty + "</set></use></template>\n";
  }
  EXPECT_THAT(texts_of(parse("<cell name='c'>" + values +
                                 "<device name='d'><use template='t7' name='x'><set name='v'>" +
                                 std::string(100, 'x') + "</set></use></device></cell>",
                             "f.xml")),
              testing::Contains(HasSubstr("more than 16 MiB of values")));

  // Neither a long chain of templates nor a long circle of templates may exhaust the parser's stack.
  std::string chain;
  for (int i = 0; i < 50000; ++i)
    chain += "<template name='c" + std::to_string(i) + "'><use template='c" +
             std::to_string((i + 1) % 50000) + "' name='u'/></template>";
  const std::string device = "<device name='d'>" + module("", "1000", "1") + "</device></cell>";
  EXPECT_THAT(texts_of(parse("<cell name='c'>" + chain + device, "f.xml")),
              ElementsAre(HasSubstr("uses itself")));
  EXPECT_THAT(texts_of(parse("<cell name='c'><template name='c50000'>" + module("", "1000", "1") +
                                 "</template>" + chain.replace(chain.rfind("'c0'"), 4, "'c50000'") + device,
                             "f.xml")),
              ElementsAre(HasSubstr("more than 8 levels deep")));
}

TEST(Parameters, AreNotReplacedAgainInsideTheirValues) {
  const std::string value = "${b}$";
  const auto of = [&](std::string_view text, int* wrong = nullptr) {
    return substituted(
        text, [&](std::string_view name) { return name == "a" ? &value : nullptr; },
        [&](auto) {
          if (wrong != nullptr) ++*wrong;
        });
  };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("a $a {a} $ {a} $"), "a $a {a} $ {a} $");
  EXPECT_EQ(of("${a}"), value);
  EXPECT_EQ(of("<${a}${a}>"), "<" + value + value + ">");
  EXPECT_EQ(of("$${a}"), "${a}");
  EXPECT_EQ(of("$${a}${a}"), "${a}" + value);
  int wrong = 0;
  EXPECT_EQ(of("x${b}y${", &wrong), "xy");
  EXPECT_EQ(wrong, 2);
}

}  // namespace
}  // namespace takt::descriptor::composition_test
