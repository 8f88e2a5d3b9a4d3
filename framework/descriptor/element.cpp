#include <takt/descriptor/element.hpp>

#include <algorithm>
#include <charconv>

#include <tinyxml2.h>

#include <takt/core/words.hpp>
#include <takt/model/validate.hpp>

namespace takt::descriptor {

namespace {

using Words = std::vector<std::string_view>;

bool contains(const Words& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string tag(std::string_view name) { return "<" + brief(name) + ">"; }

std::string trim(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return std::string{text.substr(first, text.find_last_not_of(kBlanks) - first + 1)};
}

}  // namespace

std::string Given::trimmed() const { return trim(text); }

Element::Element(const tinyxml2::XMLElement& xml, Shape shape, Report& report)
    : xml_(xml), shape_(std::move(shape)), report_(report) {
  check_attributes();
  check_children();
}

void Element::check_attributes() {
  for (const auto* one = xml_.FirstAttribute(); one != nullptr; one = one->Next()) {
    const std::string_view name = one->Name();
    if (contains(shape_.attributes, name) || report_.full()) continue;
    const std::string_view meant = nearest(name, shape_.attributes);
    if (!meant.empty()) meant_.push_back(meant);
    report_.add(one->GetLineNum(), "unknown attribute " + brief(name) + " of " + tag(xml_.Name()),
                shape_.attributes.empty() ? "remove it: " + tag(xml_.Name()) + " has no attributes"
                                          : suggestion(name, shape_.attributes));
  }
}

void Element::refuse_child(const tinyxml2::XMLElement& child) {
  unknown_children_ = true;
  if (report_.full()) return;
  Words allowed = shape_.once;
  allowed.insert(allowed.end(), shape_.many.begin(), shape_.many.end());
  const std::string_view meant = nearest(child.Name(), allowed);
  std::string fix;
  if (!meant.empty()) {
    meant_.push_back(meant);
    fix = "did you mean " + tag(meant) + "?";
  } else if (allowed.empty()) {
    fix = "remove it: " + tag(xml_.Name()) + " has no elements in it";
  } else {
    fix = "here may stand ";
    for (std::size_t i = 0; i < allowed.size(); ++i) {
      if (i > 0) fix += i + 1 == allowed.size() ? " and " : ", ";
      fix += tag(allowed[i]);
    }
  }
  report_.add(child.GetLineNum(), "unknown element " + tag(child.Name()) + " in " + tag(xml_.Name()), fix);
}

void Element::check_children() {
  std::vector<const tinyxml2::XMLElement*> seen;
  for (const auto* node = xml_.FirstChild(); node != nullptr; node = node->NextSibling()) {
    if (const auto* element = node->ToElement()) {
      if (contains(shape_.many, element->Name())) continue;
      if (!contains(shape_.once, element->Name())) {
        refuse_child(*element);
        continue;
      }
      const auto first = std::find_if(seen.begin(), seen.end(), [&](const tinyxml2::XMLElement* other) {
        return std::string_view{other->Name()} == element->Name();
      });
      if (first == seen.end()) {
        seen.push_back(element);
      } else if (!report_.full()) {
        report_.add(element->GetLineNum(),
                    "duplicate element " + tag(element->Name()) + " in " + tag(xml_.Name()),
                    "give it once; the first is on line " + std::to_string((*first)->GetLineNum()));
      }
    } else if (const auto* text = node->ToText()) {
      const std::string stray = trim(text->Value());
      if (shape_.text || stray.empty() || report_.full()) continue;
      report_.add(text->GetLineNum(), "text " + in_quotes(stray) + " in " + tag(xml_.Name()),
                  "remove it: " + tag(xml_.Name()) + " holds no text of its own");
    }
  }
}

int Element::line() const { return xml_.GetLineNum(); }

std::string Element::text() const {
  std::string all;
  for (const auto* node = xml_.FirstChild(); node != nullptr; node = node->NextSibling()) {
    if (node->ToText() != nullptr) all += node->Value();
  }
  return all;
}

Given Element::given_text() const { return {tag(xml_.Name()), text(), line(), has_unknown_children()}; }

std::optional<Given> Element::attribute(const char* name) const {
  const auto* attribute = xml_.FindAttribute(name);
  if (attribute == nullptr) return std::nullopt;
  return Given{std::string{"attribute "} + name, attribute->Value(), attribute->GetLineNum(), false};
}

std::optional<Given> Element::required_attribute(const char* name) const {
  std::optional<Given> given = attribute(name);
  if (!given && !was_meant(name)) {
    report_.add(line(), tag(xml_.Name()) + " has no attribute " + name,
                "give it one: <" + std::string{xml_.Name()} + " " + name + "=\"...\">");
  }
  return given;
}

std::vector<const tinyxml2::XMLElement*> Element::children(std::string_view name) const {
  std::vector<const tinyxml2::XMLElement*> all;
  for (const auto* one = xml_.FirstChildElement(); one != nullptr; one = one->NextSiblingElement()) {
    if (name == one->Name()) all.push_back(one);
  }
  return all;
}

const tinyxml2::XMLElement* Element::child(const char* name) const { return xml_.FirstChildElement(name); }

std::optional<Given> Element::child_text(const char* name) const {
  const auto* xml = child(name);
  if (xml == nullptr) return std::nullopt;
  return Element{*xml, {.text = true}, report_}.given_text();
}

bool Element::was_meant(std::string_view name) const { return contains(meant_, name); }

std::optional<std::int64_t> read_number(const Given& given, Range range, const char* unit, Report& report) {
  if (given.unread) return std::nullopt;
  const std::string text = given.trimmed();
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = error != std::errc::invalid_argument && end == text.data() + text.size();
  // -0 is in a range that begins with 0, and still has a sign.
  const bool sign_allowed = range.from < 0 || !text.starts_with('-');
  if (whole && sign_allowed && error == std::errc{} && number >= range.from && number <= range.to)
    return number;
  const bool open_ended = range.to == std::numeric_limits<std::int64_t>::max();
  const std::string bounds = open_ended
                                 ? ", at least " + std::to_string(range.from)
                                 : ", " + std::to_string(range.from) + " to " + std::to_string(range.to);
  const std::string what = text.empty() ? given.what + " is empty"
                           : whole      ? given.what + " is out of range: " + in_quotes(text)
                                        : given.what + " is not a whole number: " + in_quotes(text);
  report.add(given.line, what, std::string{"write a whole number"} + unit + bounds);
  return std::nullopt;
}

std::optional<std::size_t> read_choice(const Given& given, const std::vector<std::string_view>& choices,
                                       Report& report) {
  if (given.unread) return std::nullopt;
  const std::string word = given.trimmed();
  const auto found = std::find(choices.begin(), choices.end(), word);
  if (found != choices.end()) return static_cast<std::size_t>(found - choices.begin());
  report.add(
      given.line,
      word.empty() ? given.what + " is empty" : "unknown value " + in_quotes(word) + " of " + given.what,
      suggestion(word, choices));
  return std::nullopt;
}

model::OverrunContract read_contract(const Given& word, const std::optional<Given>& limit, Report& report) {
  using model::Overrun;
  constexpr Overrun kContracts[] = {Overrun::skip, Overrun::catch_up, Overrun::error, Overrun::stop_device};
  model::OverrunContract contract;
  const auto choice = read_choice(word, {"skip", "catch-up", "error", "stop-device"}, report);
  if (choice) contract.what = kContracts[*choice];
  if (!limit) return contract;
  const auto number = read_number(*limit, {1, model::kMaxCatchUp}, "", report);
  if (choice && contract.what != Overrun::catch_up) {
    report.add(limit->line, "an overrun of " + in_quotes(to_text(contract.what)) + " has a limit",
               "remove the limit, or say catch-up");
  } else if (number) {
    contract.limit = static_cast<int>(*number);
  }
  return contract;
}

}  // namespace takt::descriptor
