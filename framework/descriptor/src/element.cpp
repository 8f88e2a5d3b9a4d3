#include "element.hpp"

#include <algorithm>
#include <charconv>

#include <takt/core/words.hpp>
#include <takt/model/validate.hpp>

namespace takt::descriptor {

namespace {

using Words = std::vector<std::string_view>;

bool contains(const Words& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string tag(std::string_view name) { return "<" + brief(name) + ">"; }

}  // namespace

Element::Element(const Node& node, Shape shape, Report& report)
    : node_(node), shape_(std::move(shape)), report_(report) {
  check_attributes();
  check_children();
}

void Element::check_attributes() {
  for (const Attribute& one : node_.attributes) {
    const std::string_view name = one.name;
    if (contains(shape_.attributes, name) || report_.full()) continue;
    std::string_view meant = nearest(name, shape_.attributes);
    for (const auto& [value, attribute] : shape_.telling) {
      if (meant.empty() && value == trimmed(one.value)) meant = attribute;
    }
    if (!meant.empty()) meant_.push_back(meant);
    report_.add(one.line, "unknown attribute " + in_quotes(name) + " of " + tag(node_.name),
                shape_.attributes.empty()
                    ? "remove it: " + tag(node_.name) + " cannot have attributes" + hint()
                    : suggestion(meant.empty() ? name : meant, shape_.attributes));
  }
}

std::string Element::hint() const { return shape_.hint.empty() ? "" : "; " + std::string{shape_.hint}; }

void Element::reject_child(const Node& child) {
  unknown_children_ = true;
  if (report_.full()) return;
  Words allowed = shape_.once;
  allowed.insert(allowed.end(), shape_.many.begin(), shape_.many.end());
  const std::string_view meant = nearest(child.name, allowed);
  std::string fix;
  if (contains(shape_.attributes, child.name)) {
    fix = "write it as an attribute of " + tag(node_.name) + ": " + child.name + "=\"...\"";
  } else if (!meant.empty()) {
    meant_.push_back(meant);
    fix = "did you mean " + tag(meant) + "?";
  } else if (allowed.empty()) {
    fix = "remove it: " + tag(node_.name) + " cannot have child elements";
  } else {
    fix = tag(node_.name) + " can contain ";
    for (std::size_t i = 0; i < allowed.size(); ++i) {
      if (i > 0) fix += i + 1 == allowed.size() ? " and " : ", ";
      fix += tag(allowed[i]);
    }
  }
  report_.add(child.line, "unknown element " + tag(child.name) + " in " + tag(node_.name), fix);
}

void Element::check_children() {
  std::vector<const Node*> seen;
  for (const Node& child : node_.children) {
    if (contains(shape_.many, child.name)) continue;
    if (!contains(shape_.once, child.name)) {
      reject_child(child);
      continue;
    }
    const auto first =
        std::find_if(seen.begin(), seen.end(), [&](const Node* other) { return other->name == child.name; });
    if (first == seen.end()) {
      seen.push_back(&child);
    } else if (!report_.full()) {
      report_.add(child.line, "duplicate element " + tag(child.name) + " in " + tag(node_.name),
                  "write it only once; the first is " + report_.whereabouts((*first)->line));
    }
  }
  for (const Text& text : node_.texts) {
    const std::string stray = trimmed(text.text);
    if (shape_.text || stray.empty() || report_.full()) continue;
    if (!shape_.hint.empty() && !node_.attributes.empty())
      continue;  // the hint for the attributes says enough
    report_.add(text.line, "text " + in_quotes(stray) + " in " + tag(node_.name),
                "remove it: " + tag(node_.name) + " cannot have text" + hint());
  }
}

Given Element::given_text() const { return {tag(node_.name), text(), line(), has_unknown_children()}; }

std::optional<Given> Element::attribute(const char* name) const {
  const Attribute* attribute = node_.attribute(name);
  if (attribute == nullptr) return std::nullopt;
  return Given{"attribute " + in_quotes(name), attribute->value, attribute->line, false};
}

std::optional<Given> Element::required_attribute(const char* name) const {
  std::optional<Given> given = attribute(name);
  if (!given && !was_meant(name)) {
    report_.add(line(), tag(node_.name) + " has no attribute " + in_quotes(name),
                "add it: <" + brief(node_.name) + " " + name + "=\"...\">");
  }
  return given;
}

std::vector<const Node*> Element::children(std::string_view name) const {
  std::vector<const Node*> all;
  for (const Node& one : node_.children) {
    if (name == one.name) all.push_back(&one);
  }
  return all;
}

std::optional<Given> Element::child_text(const char* name) const {
  const Node* node = child(name);
  if (node == nullptr) return std::nullopt;
  return Element{*node, {.text = true}, report_}.given_text();
}

bool Element::was_meant(std::string_view name) const { return contains(meant_, name); }

namespace {

/// A time as written. In ns, it has the digits `whole`, `fraction` and `zeros` zeros, in this order.
struct WrittenTime {
  std::string whole{};
  std::string fraction{};
  std::size_t zeros = 0;
  std::string wrong{};  ///< what is wrong with the text; empty if it is a time
};

/// Splits the text of a time, without a sign, at its decimal point and before its unit.
WrittenTime split_time(std::string_view text) {
  constexpr std::pair<std::string_view, std::size_t> kUnits[] = {
      {"", 0}, {"ns", 0}, {"us", 3}, {"ms", 6}, {"s", 9}};
  if (text.starts_with('-')) text.remove_prefix(1);
  const auto digits = [&text] {
    const std::string_view taken = text.substr(0, text.find_first_not_of("0123456789"));
    text.remove_prefix(taken.size());
    return std::string{taken};
  };
  WrittenTime time{.whole = digits()};
  const bool has_point = text.starts_with('.');
  if (has_point) {
    text.remove_prefix(1);
    time.fraction = digits();
  }
  const std::string unit = trimmed(text);
  const bool is_word = unit.find_first_of("+-.,0123456789 \t\r\n") == std::string::npos;
  if (time.whole.empty() || (has_point && time.fraction.empty()) || !is_word) {
    time.wrong = " is not a time";
    return time;
  }
  const auto* known = std::find_if(std::begin(kUnits), std::end(kUnits),
                                   [&](const auto& each) { return each.first == unit; });
  if (known == std::end(kUnits)) {
    time.wrong = " has an unknown unit";
    return time;
  }
  while (time.fraction.ends_with('0')) time.fraction.pop_back();
  if (time.fraction.size() > known->second) {
    time.wrong = " is not a whole number of nanoseconds";
    return time;
  }
  time.zeros = known->second - time.fraction.size();
  return time;
}

}  // namespace

std::optional<std::int64_t> read_number(const Given& given, Range range, Report& report, const char* unit) {
  if (given.unread) return std::nullopt;
  const std::string text = given.trimmed();
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = error != std::errc::invalid_argument && end == text.data() + text.size();
  // The number -0 equals 0, so it would be in a range that begins with 0. But such a range allows no sign.
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

std::optional<Nanoseconds> read_time(const Given& given, TimeRange range, Report& report) {
  if (given.unread) return std::nullopt;
  const std::string text = given.trimmed();
  const WrittenTime written = split_time(text);
  std::int64_t ns = 0;
  const std::string digits = written.whole + written.fraction + std::string(written.zeros, '0');
  const bool fits = std::from_chars(digits.data(), digits.data() + digits.size(), ns).ec == std::errc{};
  const bool is_negative = text.starts_with('-');
  if (written.wrong.empty() && !is_negative && fits && Nanoseconds{ns} >= range.from &&
      Nanoseconds{ns} <= range.to)
    return Nanoseconds{ns};
  const std::string bounds = range.to == Nanoseconds::max()
                                 ? ", at least " + to_text(range.from)
                                 : ", " + to_text(range.from) + " to " + to_text(range.to);
  report.add(given.line,
             text.empty() ? given.what + " is empty"
                          : given.what + (written.wrong.empty() ? " is out of range" : written.wrong) + ": " +
                                in_quotes(text),
             "write a time in ns, us, ms or s, such as 2ms (a number alone is in ns)" + bounds);
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
  constexpr Overrun kContracts[] = {Overrun::skip, Overrun::catch_up, Overrun::error, Overrun::stop_device,
                                    Overrun::stop_cell};
  model::OverrunContract contract;
  const auto choice = read_choice(word, {"skip", "catch-up", "error", "stop-device", "stop-cell"}, report);
  if (choice) contract.what = kContracts[*choice];
  if (!limit) return contract;
  const auto number = read_number(*limit, {1, model::kMaxCatchUp}, report);
  if (choice && contract.what != Overrun::catch_up) {
    report.add(limit->line, "overrun contract " + in_quotes(to_text(contract.what)) + " has a limit",
               "remove the limit, or change the contract to catch-up");
  } else if (number) {
    contract.limit = static_cast<int>(*number);
  }
  return contract;
}

}  // namespace takt::descriptor
