// A named value of a component that the descriptor may set, and that may be set again while the component
// runs. A member of a component; of a program, or of a module in the C form, a global variable:
//
//   takt::Property<double> speed{"speed", 0.3, {.unit = "m/s", .min = 0, .max = 2, .text = "Of the belt."}};
//
// A program has the values of its descriptor as arguments, and a property of it takes its own when it is
// constructed: it is there from the first line of main() on. What it cannot take, and what no property is
// named for, initPeriodExe() or initSporadicExe() refuses.
//
// Two threads have to do with it: one that sets, and the one that calls the component's hooks at the time.
// Each has a value of its own, and a third passes from one to the other; who passes it on is a word of the
// caller (host: LiveProperties). So run() reads a plain value, that of no other call, and neither waits nor
// frees what was there before.
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <takt/core/result.hpp>

namespace takt {

class Component;

enum class PropertyType { boolean, integer, number, text };
/// "bool", "integer", "double", "string": the words of `takt describe` and of messages.
const char* to_text(PropertyType type) noexcept;

/// What can be said of a property without its C++ type.
class PropertyBase {
 public:
  PropertyBase(const PropertyBase&) = delete;
  PropertyBase& operator=(const PropertyBase&) = delete;
  virtual ~PropertyBase();

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] const std::string& unit() const noexcept { return unit_; }
  [[nodiscard]] const std::string& text() const noexcept { return text_; }
  [[nodiscard]] virtual PropertyType type() const noexcept = 0;
  /// The value that was set last. By the thread that sets.
  [[nodiscard]] virtual std::string value_text() const = 0;
  /// The value that it has until one is set.
  [[nodiscard]] virtual std::string default_text() const = 0;
  /// The least and the most that it takes; empty without that bound.
  [[nodiscard]] virtual std::string min_text() const = 0;
  [[nodiscard]] virtual std::string max_text() const = 0;
  /// "0 to 10", "at least 0", "fast or slow"; empty without bounds.
  [[nodiscard]] virtual std::string range_text() const = 0;

  /// Whether it takes this text; if not, says what it takes.
  [[nodiscard]] virtual Result<void> check(std::string_view text) const = 0;
  /// Sets it from the descriptor's text, while no hook is called. On failure it keeps its value and says what
  /// it takes.
  virtual Result<void> assign(std::string_view text) = 0;
  /// As assign(), also while hooks are called: they see it after take_over(), which must not be going on. By
  /// the thread that sets.
  virtual Result<void> propose(std::string_view text) = 0;
  /// What was proposed is the value now. By the thread that calls hooks, between two of them; once for each
  /// proposal or several of them. Real-time: swaps.
  virtual void take_over() noexcept = 0;

 protected:
  /// Of a component; or, without one, of the program or of the module in C form that is being loaded, which
  /// the last constructor then tells by detail::add_loose_property().
  PropertyBase(Component* owner, std::string name, std::string unit, std::string text);
  [[nodiscard]] Problem refusal(std::string_view given) const;

 private:
  std::string name_;
  std::string unit_;
  std::string text_;
  bool owned_;
};

/// The properties without a component of this program, or of the module in C form that this thread has loaded
/// since it was asked last, in the order of their construction. They take themselves away when they end
/// before they were asked for.
std::vector<PropertyBase*> take_loose_properties();

/// A name that is there twice, a default that is out of its range: of all of an owner.
Problems check_declared(const std::vector<PropertyBase*>& properties, const std::string& owner);

/// The words that a property of text takes: {"fast", "slow"}.
class Choices {
 public:
  Choices() noexcept = default;
  Choices(std::initializer_list<std::string> words) : words_(words) {}
  [[nodiscard]] bool empty() const noexcept { return words_.empty(); }
  [[nodiscard]] bool contain(std::string_view word) const noexcept;
  /// "fast, medium or slow"
  [[nodiscard]] std::string text() const;

 private:
  std::vector<std::string> words_;
};

namespace detail {
/// In a program the property takes its value from the arguments.
void add_loose_property(PropertyBase& property);
void remove_loose_property(PropertyBase& property) noexcept;

std::optional<bool> parse_bool(std::string_view text) noexcept;
std::optional<std::int64_t> parse_integer(std::string_view text) noexcept;
std::optional<double> parse_number(std::string_view text) noexcept;
/// The shortest text that reads back as the same value; a float's is shorter than that of the same double.
std::string number_text(double value);
std::string number_text(float value);
}  // namespace detail

template <class T>
concept PropertyValueType = std::same_as<T, bool> || std::same_as<T, std::string> || std::same_as<T, float> ||
    std::same_as<T, double> || std::signed_integral<T>;

/// bool, a signed integer, float or double, or std::string. Reading is for every hook, also on the real-time
/// thread. A value that is set while the component runs is seen from its next call on, by who reads the
/// property then: what initialize() made of it is not made again.
template <PropertyValueType T>
class Property : public PropertyBase {
 public:
  struct Options {
    std::string unit{};      ///< "mm/s"
    std::optional<T> min{};  ///< inclusive; numbers only
    std::optional<T> max{};  ///< inclusive; numbers only
    std::string text{};      ///< one sentence for `takt describe`
    Choices choices{};       ///< the words that it takes; text only, empty: any
  };

  Property(Component& owner, std::string name, T value, Options options = {})
      : Property(&owner, std::move(name), std::move(value), std::move(options)) {}
  /// Of a program, or of a module in the C form; not of a component.
  Property(std::string name, T value, Options options = {})
      : Property(nullptr, std::move(name), std::move(value), std::move(options)) {
    detail::add_loose_property(*this);
  }

  operator const T&() const noexcept { return value_; }  // NOLINT(google-explicit-constructor)
  [[nodiscard]] const T& value() const noexcept { return value_; }

  [[nodiscard]] PropertyType type() const noexcept override {
    if constexpr (std::is_same_v<T, bool>)
      return PropertyType::boolean;
    else if constexpr (std::is_integral_v<T>)
      return PropertyType::integer;
    else if constexpr (std::is_floating_point_v<T>)
      return PropertyType::number;
    else
      return PropertyType::text;
  }
  [[nodiscard]] std::string value_text() const override { return in_words(set_last_); }
  [[nodiscard]] std::string default_text() const override { return in_words(default_); }
  [[nodiscard]] std::string min_text() const override { return min_ ? in_words(*min_) : ""; }
  [[nodiscard]] std::string max_text() const override { return max_ ? in_words(*max_) : ""; }
  [[nodiscard]] std::string range_text() const override {
    std::string range;
    if (min_ && max_) {
      range = in_words(*min_) + " to " + in_words(*max_);
    } else if (min_ || max_) {
      range = min_ ? "at least " + in_words(*min_) : "at most " + in_words(*max_);
    }
    if (!choices_.empty()) range = choices_.text();
    return narrowed_.empty() ? range : range + " " + narrowed_;
  }

  /// In initialize(): a range, within the one that is declared, that only the module knows, as one that its
  /// period makes. `why` stands behind it in messages: "at a period of 1 ms". Fails when the value is out of
  /// it; later ones are held against it when they are set.
  Result<void> narrow(std::optional<T> min, std::optional<T> max,
                      std::string why) requires std::is_arithmetic_v<T> {
    if (min && (!min_ || *min > *min_)) min_ = min;
    if (max && (!max_ || *max < *max_)) max_ = max;
    narrowed_ = std::move(why);
    return check(value_text());
  }

  [[nodiscard]] Result<void> check(std::string_view text) const override {
    if (!accepted(text)) return refusal(text);
    return {};
  }
  Result<void> assign(std::string_view text) override {
    auto proposed = propose(text);
    if (proposed) take_over();
    return proposed;
  }
  Result<void> propose(std::string_view text) override {
    std::optional<T> value = accepted(text);
    if (!value) return refusal(text);
    set_last_ = *value;
    passed_on_ = std::move(*value);
    return {};
  }
  void take_over() noexcept override { std::swap(value_, passed_on_); }

 private:
  Property(Component* owner, std::string name, T value, Options options)
      : PropertyBase(owner, std::move(name), std::move(options.unit), std::move(options.text)),
        default_(std::move(value)),
        value_(default_),
        set_last_(default_),
        min_(options.min),
        max_(options.max),
        choices_(std::move(options.choices)) {}

  static std::string in_words(const T& value) {
    if constexpr (std::is_same_v<T, bool>)
      return value ? "true" : "false";
    else if constexpr (std::is_integral_v<T>)
      return std::to_string(value);
    else if constexpr (std::is_floating_point_v<T>)
      return detail::number_text(value);
    else
      return value;
  }

  std::optional<T> accepted(std::string_view text) const {
    std::optional<T> value = parse(text);
    if constexpr (std::is_arithmetic_v<T>) {
      // Written so that a NaN is refused wherever there is a bound.
      if (value && ((min_ && !(*value >= *min_)) || (max_ && !(*value <= *max_)))) value.reset();
    }
    if constexpr (std::is_same_v<T, std::string>) {
      if (value && !choices_.empty() && !choices_.contain(*value)) value.reset();
    }
    return value;
  }

  static std::optional<T> parse(std::string_view text) {
    if constexpr (std::is_same_v<T, bool>)
      return detail::parse_bool(text);
    else if constexpr (std::is_integral_v<T>) {
      const auto value = detail::parse_integer(text);
      return value && std::in_range<T>(*value) ? std::optional<T>(static_cast<T>(*value)) : std::nullopt;
    } else if constexpr (std::is_floating_point_v<T>) {
      const auto value = detail::parse_number(text);
      // A float does not take what only a double can hold.
      return value && std::abs(*value) <= static_cast<double>(std::numeric_limits<T>::max())
                 ? std::optional<T>(static_cast<T>(*value))
                 : std::nullopt;
    } else {
      return std::string{text};
    }
  }

  const T default_;
  T value_;        // of the thread that calls hooks
  T passed_on_{};  // of the one that sets, until take_over(); then what was the value
  T set_last_;     // of the one that sets
  std::optional<T> min_;
  std::optional<T> max_;
  Choices choices_;
  std::string narrowed_;  // why the range is what it is
};

}  // namespace takt
