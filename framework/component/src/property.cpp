#include <takt/component/property.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include <takt/component.hpp>
#include <takt/core/log_level.hpp>
#include <takt/core/words.hpp>

namespace takt {

const char* to_text(PropertyType type) noexcept {
  switch (type) {
    case PropertyType::boolean:
      return "bool";
    case PropertyType::integer:
      return "integer";
    case PropertyType::number:
      return "double";
    case PropertyType::text:
      return "string";
  }
  return "?";
}

PropertyBase::PropertyBase(Component* owner, std::string name, std::string unit, std::string text)
    : name_(std::move(name)), unit_(std::move(unit)), text_(std::move(text)), owned_(owner != nullptr) {
  if (owned_ && !detail::report_late("property '" + name_ + "'")) owner->properties_.push_back(this);
}

PropertyBase::~PropertyBase() {
  if (!owned_) detail::remove_loose_property(*this);
}

Problems check_declared(const std::vector<PropertyBase*>& properties, const std::string& owner) {
  Problems problems;
  for (auto one = properties.begin(); one != properties.end(); ++one) {
    const std::string& name = (*one)->name();
    if (std::any_of(properties.begin(), one,
                    [&](const PropertyBase* other) { return other->name() == name; }))
      problems.push_back(
          takt::fail(owner + " has two properties '" + name + "'", "give each a different name"));
    if (name == kLogLevelProperty)
      problems.push_back(
          takt::fail(owner + " declares property '" + name +
                         "', but every module already has this property, for the level of its log",
                     "give the property another name"));
    const auto least = detail::parse_number((*one)->min_text());
    const auto most = detail::parse_number((*one)->max_text());
    if (least && most && *least > *most) {
      problems.push_back(takt::fail(owner + " has a property '" + name + "' whose minimum " +
                                        (*one)->min_text() + " is greater than its maximum " +
                                        (*one)->max_text(),
                                    "exchange the bounds or correct one of them"));
      continue;
    }
    // The default must be a value that the property accepts.
    const std::string range = (*one)->range_text();
    if (range.empty() || (*one)->check((*one)->default_text())) continue;
    problems.push_back(takt::fail(owner + " has a property '" + name + "' whose default " +
                                      brief((*one)->default_text()) + " is out of its range: " + range,
                                  "change the default or the range"));
  }
  return problems;
}

Problem PropertyBase::refusal(std::string_view given) const {
  std::string what = "property '" + name_ + "' cannot be " + in_quotes(given);
  std::string takes;
  switch (type()) {
    case PropertyType::boolean:
      takes = "true or false";
      break;
    case PropertyType::integer:
      takes = "a whole number";
      break;
    case PropertyType::number:
      takes = "a number";
      break;
    case PropertyType::text:
      takes = "text";
      break;
  }
  if (const std::string range = range_text(); !range.empty()) takes += ", " + range;
  if (!unit_.empty() && unit_ != "1") {  // "1" means that the number has no unit
    takes += ", in " + unit_;
    if (given.ends_with(unit_)) {
      given.remove_suffix(unit_.size());
      while (given.ends_with(' ')) given.remove_suffix(1);
      if (detail::parse_number(given)) takes += ", without the unit";
    }
  }
  return takt::fail(std::move(what), "it takes " + takes);
}

bool Choices::contain(std::string_view word) const noexcept {
  return std::find(words_.begin(), words_.end(), word) != words_.end();
}

std::string Choices::text() const {
  std::string text;
  for (std::size_t i = 0; i < words_.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words_.size() ? " or " : ", ") + words_[i];
  return text;
}

namespace detail {

std::optional<bool> parse_bool(std::string_view text) noexcept {
  if (text == "true" || text == "1") return true;
  if (text == "false" || text == "0") return false;
  return std::nullopt;
}

namespace {
template <class T>
std::optional<T> parse_whole(std::string_view text) noexcept {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}
}  // namespace

std::optional<std::int64_t> parse_integer(std::string_view text) noexcept {
  return parse_whole<std::int64_t>(text);
}

std::optional<double> parse_number(std::string_view text) noexcept {
  const auto value = parse_whole<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

namespace {
template <class T>
std::string shortest(T value) {
  std::array<char, 32> buffer{};
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), end};
}
}  // namespace

std::string number_text(double value) { return shortest(value); }
std::string number_text(float value) { return shortest(value); }

}  // namespace detail

}  // namespace takt
