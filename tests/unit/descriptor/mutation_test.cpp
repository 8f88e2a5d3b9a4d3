// Changes valid descriptors at every position, in every way that must make them invalid. The parser must
// reject each changed text with a line number, and must not crash.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <folders.hpp>
#include <takt/descriptor/descriptor.hpp>

namespace takt::descriptor::mutation_test {
namespace {

std::string content_of(const std::string& file) {
  std::ostringstream content;
  content << std::ifstream{file, std::ios::binary}.rdbuf();
  return content.str();
}

struct Span {
  std::size_t begin = 0;
  std::size_t end = 0;
};

struct Attribute {
  std::string name;
  Span whole;  // the whole attribute: name="value"
  Span value;  // the value without the quotes
};

/// An element of a valid document, with the positions of its tags.
struct Element {
  std::string name;
  std::string parent;
  std::size_t parent_end = 0;  // the position after the parent's closing tag; 0 for the root
  Span start;                  // the opening tag <name ...>
  Span end;                    // the closing tag </name>; empty for <name/>
  std::vector<Attribute> attributes;

  [[nodiscard]] bool closes_itself() const { return end.begin == end.end; }
  [[nodiscard]] std::size_t past() const { return closes_itself() ? start.end : end.end; }
};

/// Lists the elements of a simple XML document. This function is independent of the parser under test.
std::vector<Element> elements_of(const std::string& xml) {
  std::vector<Element> all;
  std::vector<std::size_t> open;
  std::vector<std::size_t> parents;
  for (std::size_t at = xml.find('<'); at != std::string::npos; at = xml.find('<', at + 1)) {
    if (xml.compare(at, 4, "<!--") == 0) {
      at = xml.find("-->", at);
    } else if (xml[at + 1] == '/') {
      all[open.back()].end = {at, xml.find('>', at) + 1};
      open.pop_back();
    } else if (xml[at + 1] != '?') {
      Element element;
      element.start = {at, xml.find('>', at) + 1};
      element.name = xml.substr(at + 1, xml.find_first_of(" />", at) - at - 1);
      if (!open.empty()) element.parent = all[open.back()].name;
      for (std::size_t eq = xml.find('=', at); eq < element.start.end; eq = xml.find('=', eq + 1)) {
        const std::size_t name = xml.rfind(' ', eq) + 1;
        const std::size_t quote = xml.find('"', eq + 2);
        element.attributes.push_back({xml.substr(name, eq - name), {name, quote + 1}, {eq + 2, quote}});
      }
      parents.push_back(open.empty() ? all.size() : open.back());
      if (xml[element.start.end - 2] != '/') open.push_back(all.size());
      all.push_back(element);
    }
  }
  for (std::size_t i = 1; i < all.size(); ++i) all[i].parent_end = all[parents[i]].past();
  return all;
}

std::string replaced(const std::string& xml, Span span, const std::string& by) {
  return xml.substr(0, span.begin) + by + xml.substr(span.end);
}
std::string inserted(const std::string& xml, std::size_t at, const std::string& text) {
  return replaced(xml, {at, at}, text);
}
std::string part(const std::string& xml, Span span) { return xml.substr(span.begin, span.end - span.begin); }

int line_of(const std::string& xml, std::size_t at) {
  return 1 + static_cast<int>(std::count(xml.begin(), xml.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
}

class Mutations {
 public:
  /// `optional` names the attributes that the text does not need to be valid, such as "cpu" or
  /// "connection/from".
  Mutations(std::string xml, std::set<std::string> optional)
      : xml_(std::move(xml)), optional_(std::move(optional)) {}

  /// Expects that the parser rejects the changed text `xml`. If `line` is given, one problem must be in that
  /// line.
  void expect_rejected(const std::string& mutation, const std::string& xml, int line = 0) {
    SCOPED_TRACE(mutation);
    if (!seen_.insert(xml).second) return;
    const auto cell = parse(xml, "base.xml");
    ASSERT_FALSE(cell) << xml;
    bool found = line == 0;
    const int last = line_of(xml, xml.size());
    for (const Problem& problem : cell.problems()) {
      ASSERT_EQ(problem.where.substr(0, 9), "base.xml:") << problem.where;
      const int where = std::stoi(problem.where.substr(9));
      EXPECT_GE(where, 1);
      EXPECT_LE(where, last);
      EXPECT_FALSE(problem.what.empty());
      EXPECT_FALSE(problem.fix.empty()) << problem.what;
      EXPECT_EQ(to_text(problem).find('\n'), std::string::npos);
      found = found || where == line;
    }
    EXPECT_TRUE(found) << "no problem on line " << line << ":\n" << to_text(cell.problems());
  }

  void break_markup(const Element& e);
  void break_structure(const Element& e);
  void break_text(const Element& e);
  void break_attributes(const Element& e);
  void break_document();

  /// Returns the number of different texts that were tested.
  [[nodiscard]] std::size_t count() const { return seen_.size(); }

 private:
  std::string xml_;
  std::set<std::string> optional_;
  std::set<std::string> seen_;
};

const std::set<std::string> kTextElements{"name",     "filename", "moduletype",   "operationtype", "period",
                                          "deadline", "dispatch", "interarrival", "priority",      "executor",
                                          "budget",   "value",    "offset",       "overrun",       "set",
                                          "retain",   "argument"};

/// Breaks the markup, so that the text is not well-formed.
void Mutations::break_markup(const Element& e) {
  const int line = line_of(xml_, e.start.begin);
  const std::string tag = "<" + e.name + ">";
  expect_rejected("no < of " + tag, replaced(xml_, {e.start.begin, e.start.begin + 1}, ""));
  expect_rejected("no > of " + tag, replaced(xml_, {e.start.end - 1, e.start.end}, ""));
  expect_rejected("blank after < of " + tag, inserted(xml_, e.start.begin + 1, " "), line);
  expect_rejected("digit after < of " + tag, inserted(xml_, e.start.begin + 1, "1"), line);
  expect_rejected("&-sign before " + tag, inserted(xml_, e.start.begin, "&"));
  expect_rejected("entity before " + tag, inserted(xml_, e.start.begin, "&none;"));
  expect_rejected("zero byte in " + tag, inserted(xml_, e.start.begin + 2, std::string(1, '\0')), line);
  expect_rejected("control byte in " + tag, inserted(xml_, e.start.begin + 2, "\x01"), line);
  expect_rejected("byte that is not UTF-8 in " + tag, inserted(xml_, e.start.begin + 2, "\xff"), line);
  expect_rejected("overlong character in " + tag, inserted(xml_, e.start.begin + 2, "\xc0\xaf"), line);
  expect_rejected("comment that is not closed before " + tag, inserted(xml_, e.start.begin, "<!--"));
  expect_rejected("cdata that is not closed before " + tag, inserted(xml_, e.start.begin, "<![CDATA["));
  expect_rejected("entity declaration before " + tag, inserted(xml_, e.start.begin, "<!ENTITY x 'y'>"), line);
  expect_rejected("instruction before " + tag, inserted(xml_, e.start.begin, "<?php go() ?>"), line);
  expect_rejected("cut before " + tag, xml_.substr(0, e.start.begin));
  expect_rejected("cut in " + tag, xml_.substr(0, e.start.begin + 2));
  expect_rejected("cut in the end of " + tag, xml_.substr(0, e.start.end - 1));
  if (e.closes_itself()) return;
  expect_rejected("no " + tag, replaced(xml_, e.start, ""));
  expect_rejected("no closing of " + tag, replaced(xml_, e.end, ""));
  expect_rejected("two closings of " + tag, inserted(xml_, e.end.end, part(xml_, e.end)));
  expect_rejected("closed by itself and again " + tag, inserted(xml_, e.start.end - 1, "/"));
  expect_rejected("no slash in closing of " + tag, replaced(xml_, {e.end.begin + 1, e.end.begin + 2}, ""));
  expect_rejected("other name in closing of " + tag, inserted(xml_, e.end.begin + 3, "x"),
                  line_of(xml_, e.end.begin));
  expect_rejected("attribute of closing of " + tag, inserted(xml_, e.end.end - 1, " a=\"1\""),
                  line_of(xml_, e.end.begin));
  expect_rejected("cut after " + tag, xml_.substr(0, e.start.end));
  expect_rejected("cut in closing of " + tag, xml_.substr(0, e.end.begin + 2));
}

/// Breaks the structure: moves, repeats or removes an element.
void Mutations::break_structure(const Element& e) {
  const int line = line_of(xml_, e.start.begin);
  const std::string tag = "<" + e.name + ">";
  const std::string whole = part(xml_, {e.start.begin, e.past()});
  const auto renamed = [&](const std::string& name) {
    std::string xml = xml_;
    if (!e.closes_itself()) xml.replace(e.end.begin + 2, e.name.size(), name);
    return xml.replace(e.start.begin + 1, e.name.size(), name);
  };
  expect_rejected("slip in the name of " + tag, renamed(e.name + e.name.back()), line);
  expect_rejected("other case of " + tag,
                  renamed(std::string(1, static_cast<char>(e.name[0] - 'a' + 'A')) + e.name.substr(1)), line);
  expect_rejected("other name for " + tag, renamed("nonsense"), line);
  expect_rejected("prefix on " + tag, renamed("x:" + e.name), line);

  // The text must not contain this element twice: the element is allowed only once, or its name or the ends
  // of its connection must be unique. Only <argument> may be repeated.
  if (e.name != "argument") expect_rejected("twice " + tag, inserted(xml_, e.past(), whole));
  expect_rejected("wrapped " + tag, replaced(xml_, {e.start.begin, e.past()}, "<wrap>" + whole + "</wrap>"),
                  line);
  // Moves the element out of its parent, to a place where the element is not allowed.
  if (e.parent_end != 0) {
    expect_rejected("out of its parent " + tag,
                    replaced(inserted(xml_, e.parent_end, whole), {e.start.begin, e.past()}, ""));
  }
  // These elements are optional: without <name>, a module is named after its file, and the other elements may
  // be missing if nothing in the text refers to them.
  static const std::set<std::string> kOptional{
      "name",         "budget", "recovery", "property", "value",     "connection", "dispatch",
      "interarrival", "offset", "overrun",  "retain",   "arguments", "argument"};
  const bool one_of_many = e.name == "module" && e.parent == "root";
  const bool only_executor = e.name == "executor" && e.parent == "module";
  if (kOptional.count(e.name) == 0 && !one_of_many && !only_executor) {
    expect_rejected("without " + tag, replaced(xml_, {e.start.begin, e.past()}, ""));
  }
  if (e.closes_itself()) return;
  expect_rejected("unknown element in " + tag, inserted(xml_, e.start.end, "<nonsense/>"), line);
  expect_rejected("itself in " + tag, inserted(xml_, e.start.end, whole), line);
  if (kTextElements.count(e.name) == 0) {
    expect_rejected("text in " + tag, inserted(xml_, e.start.end, "stray"), line);
    expect_rejected("cdata in " + tag, inserted(xml_, e.start.end, "<![CDATA[stray]]>"), line);
  }
}

void Mutations::break_text(const Element& e) {
  static const std::vector<std::string> kNoNumber{"",
                                                  " ",
                                                  "-1",
                                                  "+1",
                                                  "1.5",
                                                  "1,5",
                                                  "0x1F",
                                                  "1e3",
                                                  "1 2",
                                                  "five",
                                                  "1m",
                                                  "--1",
                                                  "1_000",
                                                  "NaN",
                                                  "99999999999999999999",
                                                  "9223372036854775808",
                                                  "\u0661"};
  static const std::vector<std::string> kNoWord{"",      "x",       "Thread",  "PERIODIC", "thread process",
                                                "tread", "perodic", "nonreal", "0"};
  static const std::vector<std::string> kNoName{
      "", "7x", "a.b", "a b", "-a", "gr\u00f6\u00dfe", "a/b", std::string(64, 'x')};
  // Only a priority may be negative.
  const bool priority = e.name == "priority";
  const bool number = priority || e.name == "period" || e.name == "deadline" || e.name == "budget" ||
                      e.name == "interarrival" || e.name == "offset";
  std::vector<std::string> wrong;
  if (number) wrong = kNoNumber;
  if (number && !priority && e.name != "offset") wrong.emplace_back("0");
  if (e.name == "offset") wrong.emplace_back("1000000");  // an offset must be less than the period
  if (priority) wrong.insert(wrong.end(), {"2147483648", "-2147483649"});
  if (e.name == "moduletype" || e.name == "operationtype" || e.name == "dispatch" || e.name == "overrun")
    wrong = kNoWord;
  // Invalid names. The <executor> of a module must also name an existing executor, which "nobody" does not.
  if (e.name == "name" || (e.name == "executor" && e.parent == "module")) wrong = kNoName;
  if (e.name == "executor" && e.parent == "module") wrong.emplace_back("nobody");
  if (e.name == "filename") wrong = {"", " \n ", std::string(4097, 'x')};
  for (const std::string& text : wrong) {
    if (priority && text == "-1") continue;
    expect_rejected("<" + e.name + "> is '" + text + "'", replaced(xml_, {e.start.end, e.end.begin}, text),
                    line_of(xml_, e.start.begin));
  }
  if (e.name != "operationtype") return;
  // A module becomes invalid if only its operation type changes: the new type requires elements that the
  // module does not have, and forbids some elements that the module has.
  const std::string is = part(xml_, {e.start.end, e.end.begin});
  const std::string module =
      xml_.substr(xml_.rfind("<module>", e.start.begin),
                  xml_.find("</module>", e.start.begin) - xml_.rfind("<module>", e.start.begin));
  const bool thread = module.find("thread") != std::string::npos;
  const bool plain =
      module.find("<executor>") == std::string::npos && module.find("<budget>") == std::string::npos;
  for (const std::string kind : {"periodic", "sporadic", "non-real"}) {
    if (kind == is) continue;
    // A periodic thread module without <executor> and <budget> stays valid if it becomes non-real-time.
    if (is == "periodic" && kind == "non-real" && thread && plain) continue;
    expect_rejected(is + " becomes " + kind, replaced(xml_, {e.start.end, e.end.begin}, kind));
  }
}

void Mutations::break_attributes(const Element& e) {
  const int line = line_of(xml_, e.start.begin);
  const std::size_t at = e.start.begin + 1 + e.name.size();
  expect_rejected("unknown attribute of <" + e.name + ">", inserted(xml_, at, " nonsense=\"1\""), line);
  expect_rejected("attribute without value of <" + e.name + ">", inserted(xml_, at, " nonsense"), line);

  static const std::map<std::string, std::vector<std::string>> kWrong{
      {"domain", {"-1", "-0", "233", "7x", "1.0"}},
      {"cpu", {"-1", "-0", "1024", "one", "0x1"}},
      {"priority", {"0", "1", "99", "-80", "high"}},
      {"wakeup", {"Hybrid", "hybird", "busy"}},
      {"attempts", {"-1", "-0", "1001", "three"}},
      {"backoff", {"-1", "-0", "3600000000001", "100mm"}},
      {"then", {"stop", "Destruct", "stop_device"}},
      {"from",
       {"robot", "robot.trajectory", "robot.trajectory.setpoint.x", "nobody.trajectory.x", "robot.nobody.x",
        "..", "robot..x"}},
      {"to",
       {"line", "line.conveyor", ".conveyor.x", "nobody.conveyor.x", "line.nobody.x", "..", ".", "line..x"}},
      {"kind", {"newest", "Latest", "queues"}},
      {"deadline", {"0", "-1", "20 m s", "2e7"}},
      {"stale", {"drop", "Error"}},
      {"depth", {"0", "-1", "65537", "eight", "8.0"}},
      {"reliability", {"best_effort", "besteffort", "Reliable", "exactly-once"}},
      {"lifespan", {"0", "-1", "5.ms", "5e7", "9223372036854775808"}},
      {"topic", {"a b", "takt/a", "takt/", "\u00e4", "a&#10;b", "a&#127;", std::string(256, 'x')}},
      {"miss", {"Error", "fail", "ignore"}},
      {"spin", {"-1", "91", "0.4", "40%"}},
      {"overrun", {"Skip", "catchup", "catch up", "stop"}},
      {"limit", {"0", "-1", "1001", "three"}},
      {"offsets", {"Auto", "best", "automatic"}},
      {"timing", {"LET", "logical", "Direct"}},
      {"host", {"Own", "process", "none"}},
      {"times", {"0", "-1", "1001", "2.5"}},
      {"in-a-row", {"0", "-1", "1001", "five"}},
      {"hang", {"0", "-1", "30min", "3e7", "400000", "9223372036854775808"}},
      {"discovery", {"multicast", "Server", "unicast", "none"}},
      {"peers",
       {"10.0.0.1,line.local", "10.0.0.1:7400", "10.0.0.256", "10.0.0", "10.0.0.01", "-line", "line-", "a..b",
        "10.0.0.1 10.0.0.1", "::1", "l\u00e4", std::string(64, 'x')}},
      {"server",
       {"10.0.0.1", "10.0.0.1:", ":11811", "10.0.0.1:0", "10.0.0.1:65536", "10.0.0.1:+1", "10.0.0.1:01",
        "10.0.0.1:11811 10.0.0.2:11811", "10.0.0.1:x", "[::1]:11811", "10.0.0.256:11811"}},
      {"server-device", {"nobody", "robt", "Robot", "robot line", "robot.trajectory"}},
      {"security", {"Required", "on", "yes", "none"}},
      {"template", {"nobody", "Axis", "7x", "axis pair"}},
      {"port", {"7x", "a.b", "a b"}},
      {"of", {"servo", "servo.", ".setpoint", "nobody.x", "servo.a.b", "robot.first.state"}},
      {"name", {"7x", "a.b", "a b", "gr\u00f6\u00dfe", std::string(64, 'x')}},
  };
  for (const Attribute& a : e.attributes) {
    const std::string what = e.name + "/" + a.name;
    const std::string value = part(xml_, a.value);
    expect_rejected("twice " + what, inserted(xml_, a.whole.end, " " + part(xml_, a.whole)), line);
    expect_rejected("slip in " + what, inserted(xml_, a.whole.begin + 1, "x"), line);
    expect_rejected("other case of " + what, replaced(xml_, {a.whole.begin, a.whole.begin + 1}, "X"), line);
    expect_rejected("empty " + what, replaced(xml_, a.value, ""), line);
    expect_rejected("no = in " + what, replaced(xml_, {a.value.begin - 2, a.value.begin - 1}, ""), line);
    expect_rejected("no quotes in " + what, replaced(xml_, {a.value.begin - 1, a.value.end + 1}, value),
                    line);
    expect_rejected("no second quote in " + what, replaced(xml_, {a.value.end, a.value.end + 1}, ""));
    expect_rejected("< in " + what, inserted(xml_, a.value.begin, "<"), line);
    expect_rejected("& in " + what, inserted(xml_, a.value.begin, "&"), line);
    expect_rejected("line feed in " + what,
                    inserted(xml_, a.value.begin + 1, value.size() > 1 ? "\n" : "\nx"));
    expect_rejected("cut in " + what, xml_.substr(0, a.value.begin + 1));
    if (optional_.count(a.name) + optional_.count(what) == 0)
      expect_rejected("without " + what, replaced(xml_, a.whole, ""), line);
    const auto wrong = kWrong.find(a.name);
    ASSERT_NE(wrong, kWrong.end()) << what;
    for (const std::string& text : wrong->second) {
      expect_rejected(what + " is " + text, replaced(xml_, a.value, text), line);
    }
  }
  // Connects the port in `from` to itself.
  if (e.name != "connection" || e.attributes[0].name != "from" || e.attributes[1].name != "to") return;
  expect_rejected("to itself", replaced(xml_, e.attributes[1].value, part(xml_, e.attributes[0].value)),
                  line);
}

void Mutations::break_document() {
  const std::string body = xml_.substr(xml_.find("?>") + 2);
  expect_rejected("nothing", "");
  expect_rejected("blanks", " \n\t ");
  expect_rejected("comment only", "<!-- nothing -->");
  expect_rejected("declaration only", "<?xml version=\"1.0\"?>");
  expect_rejected("text only", "takt");
  expect_rejected("document type", "<!DOCTYPE root>" + body);
  expect_rejected("entity", "<!DOCTYPE root [<!ENTITY a 'b'>]>" + body);
  expect_rejected("instruction", "<?xml-stylesheet href='a'?>" + body);
  expect_rejected("declaration after a blank", " " + xml_);
  expect_rejected("declaration twice", "<?xml version=\"1.0\"?>" + xml_);
  expect_rejected("declaration at the end", xml_ + "<?xml version=\"1.0\"?>");
  expect_rejected("XML 1.1", "<?xml version=\"1.1\"?>" + body);
  expect_rejected("no version", "<?xml encoding=\"UTF-8\"?>" + body);
  expect_rejected("Latin 1", "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>" + body);
  expect_rejected("wrong encoding UTF-16", "<?xml version=\"1.0\" encoding=\"UTF-16\"?>" + body);
  expect_rejected("standalone maybe", "<?xml version=\"1.0\" standalone=\"maybe\"?>" + body);
  expect_rejected("no quotes", "<?xml version=1.0?>" + body);
  expect_rejected("no end of declaration", "<?xml version=\"1.0\">" + body);
  expect_rejected("unknown in declaration", "<?xml version=\"1.0\" a=\"b\"?>" + body);
  expect_rejected("UTF-16 mark", "\xff\xfe" + xml_);
  expect_rejected("byte mark twice", "\xef\xbb\xbf\xef\xbb\xbf" + body);
  expect_rejected("text after", xml_ + "x");
  expect_rejected("element after", xml_ + "<root/>");
  expect_rejected("the whole twice", xml_ + body);
  expect_rejected("closing after", xml_ + "</root>");
  expect_rejected("cdata after", xml_ + "<![CDATA[]]>");
  expect_rejected("zero byte after", xml_ + std::string(1, '\0'));
  expect_rejected("surrogate after", xml_ + "<!-- \xed\xa0\x80 -->");
  expect_rejected("noncharacter after", xml_ + "<!-- \xef\xbf\xbf -->");
  expect_rejected("dashes in comment", xml_ + "<!-- a -- b -->");
}

struct Base {
  std::string file;
  std::set<std::string> optional;
};

const std::vector<Base>& bases() {
  static const std::string kGood = "tests/unit/descriptor/cases/good/";
  // These attributes are optional in every base file. Other attributes are optional only in some files: in
  // cell.xml, some attributes require each other; in everything.xml, a topic or a queue requires some
  // attributes.
  static const std::set<std::string> kDefaults{"domain",   "cpu",     "priority", "wakeup",
                                               "attempts", "backoff", "then"};
  std::set<std::string> cell = kDefaults;
  cell.insert({"kind", "stale"});
  std::set<std::string> everything = kDefaults;
  everything.insert({"depth", "reliability", "lifespan", "stale", "miss", "server-device", "connection/from",
                     "spin", "limit", "offsets", "timing", "host", "times", "in-a-row", "hang"});
  static const std::vector<Base> kBases{{"deploy/module.xml", kDefaults},
                                        {kGood + "cell.xml", cell},
                                        {kGood + "everything.xml", everything},
                                        {kGood + "peers.xml", kDefaults},
                                        {kGood + "template.xml", kDefaults}};
  return kBases;
}

std::size_t break_everywhere(const Base& base) {
  const std::string xml = content_of(source_path(base.file));
  EXPECT_TRUE(parse(xml, "base.xml")) << base.file << " must be valid before it is broken";
  Mutations mutations{xml, base.optional};
  for (const Element& element : elements_of(xml)) {
    mutations.break_markup(element);
    mutations.break_structure(element);
    mutations.break_text(element);
    mutations.break_attributes(element);
  }
  mutations.break_document();
  return mutations.count();
}

TEST(DescriptorMutations, ThatBreakARuleAreRejectedWithALineNumber) {
  for (const Base& base : bases()) {
    SCOPED_TRACE(base.file);
    const std::size_t mutations = break_everywhere(base);
    RecordProperty(base.file, static_cast<int>(mutations));
    EXPECT_GE(mutations, 300U);
  }
}

// The parser must accept changes that have no effect on the cell. Without this test, a parser that rejects
// every text would pass.
TEST(DescriptorMutations, WithoutEffectOnTheCellAreAccepted) {
  for (const Base& base : bases()) {
    const std::string xml = content_of(source_path(base.file));
    for (const Element& element : elements_of(xml)) {
      SCOPED_TRACE(base.file + " <" + element.name + ">");
      EXPECT_TRUE(parse(inserted(xml, element.start.begin, "<!-- so -->"), "base.xml"));
      EXPECT_TRUE(parse(inserted(xml, element.start.begin, " \n\t"), "base.xml"));
      EXPECT_TRUE(parse(inserted(xml, element.start.end, "\n"), "base.xml"));
      EXPECT_TRUE(parse(inserted(xml, element.start.begin + 1 + element.name.size(), "\n"), "base.xml"));
      for (const Attribute& attribute : element.attributes) {
        if (base.optional.count(attribute.name) + base.optional.count(element.name + "/" + attribute.name) ==
            0)
          continue;
        // Without `from`, a connection that has no `to` would have no port.
        if (element.name == "connection" && attribute.name == "from" && element.attributes[1].name != "to")
          continue;
        const auto cell = parse(replaced(xml, attribute.whole, ""), "base.xml");
        EXPECT_TRUE(cell) << "without " << attribute.name << "\n" << to_text(cell.problems());
      }
      if (element.closes_itself()) continue;
      EXPECT_TRUE(parse(inserted(xml, element.end.end - 1, " "), "base.xml"));
    }
  }
}

}  // namespace
}  // namespace takt::descriptor::mutation_test
