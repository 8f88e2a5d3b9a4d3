// takt::Property: a named value that the descriptor sets, and that an operator can change while the component
// runs. It is a member of a component. In a process module it is a global variable:
//
//   takt::Property<double> speed{"speed", 0.3, {.unit = "m/s", .min = 0, .max = 2, .text = "Belt speed."}};
//
// A process module gets the values of its descriptor as arguments, and each property takes its value from the
// arguments when it is constructed, before main(). initPeriodExe() or initSporadicExe() rejects invalid
// values, and arguments that name no property. A value that is set later is current when waitPeriod() or
// waitSporadic() returns. The name `log-level` is reserved: this property of every module sets the level of
// its log, and the module does not receive it.
//
// Two threads use a property: the one that sets it, and the one that calls the hooks, or waitPeriod(). Each
// thread has its own copy of the value, and the threads pass a third copy to each other. One atomic word
// synchronises this exchange (see LiveProperties). So run() reads a plain value that no other thread changes,
// and neither waits nor frees the former value.
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

#include <takt/component/owner.hpp>
#include <takt/core/result.hpp>

namespace takt {

class Component;

/// The kind of value that a property has.
enum class PropertyType {
  boolean,  ///< bool
  integer,  ///< a signed integer
  number,   ///< float or double
  text      ///< std::string
};
/// Returns "bool", "integer", "double" or "string", as in `takt describe` and in messages.
const char* to_text(PropertyType type) noexcept;

/// The part of a property that does not depend on its C++ type.
class PropertyBase {
 public:
  PropertyBase(const PropertyBase&) = delete;
  PropertyBase& operator=(const PropertyBase&) = delete;
  virtual ~PropertyBase();

  /// The name of the property.
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  /// The unit of the value; may be empty.
  [[nodiscard]] const std::string& unit() const noexcept { return unit_; }
  /// The description for `takt describe`; may be empty.
  [[nodiscard]] const std::string& text() const noexcept { return text_; }
  /// The kind of value.
  [[nodiscard]] virtual PropertyType type() const noexcept = 0;
  /// The value that was set last. Only the setting thread may call it. Allocates memory.
  [[nodiscard]] virtual std::string value_text() const = 0;
  /// The default value of the property. Allocates memory.
  [[nodiscard]] virtual std::string default_text() const = 0;
  /// The smallest accepted value; empty without a lower bound. Allocates memory.
  [[nodiscard]] virtual std::string min_text() const = 0;
  /// The largest accepted value; empty without an upper bound. Allocates memory.
  [[nodiscard]] virtual std::string max_text() const = 0;
  /// The accepted values as text: "0 to 10", "at least 0", "fast or slow"; empty without bounds. Allocates
  /// memory.
  [[nodiscard]] virtual std::string range_text() const = 0;

  /// Checks whether the property accepts this text. If not, the problem states what the property accepts. Not
  /// for real-time threads.
  [[nodiscard]] virtual Result<void> check(std::string_view text) const = 0;
  /// Sets the property from the descriptor's text, while no hook is called. On failure the value does not
  /// change, and the problem states what the property accepts. Not for real-time threads.
  virtual Result<void> assign(std::string_view text) = 0;
  /// Like assign(), but also allowed while other threads call hooks. The hooks see the new value only after
  /// take_over(). propose() must not be called while take_over() is in progress. Only the setting thread may
  /// call propose(). Not for real-time threads.
  virtual Result<void> propose(std::string_view text) = 0;
  /// Makes the proposed value the current one. The thread that calls the hooks calls take_over() between two
  /// hooks, once after one or more proposals. A real-time thread may call it, because it only swaps two
  /// values.
  virtual void take_over() noexcept = 0;

 protected:
  /// `owner`: the component; null in a process module, or in a module in C form that is being loaded. In
  /// these cases the constructor of the derived class registers the property with
  /// detail::add_loose_property().
  PropertyBase(Component* owner, std::string name, std::string unit, std::string text);
  /// Returns the problem for a rejected text; the problem states what the property accepts.
  [[nodiscard]] Problem refusal(std::string_view given) const;

 private:
  std::string name_;
  std::string unit_;
  std::string text_;
  bool owned_;
};

/// Returns the properties that belong to no component, in the order of construction: in a process module, all
/// its properties; in a host, those of the module in C form that this thread has loaded since the last call.
/// Properties that were destroyed before the call are not in the list.
std::vector<PropertyBase*> take_loose_properties();

/// Reports duplicate names and defaults out of range among the properties of one component. `owner`: the name
/// of the component in the messages. Not for real-time threads.
Problems check_declared(const std::vector<PropertyBase*>& properties, const std::string& owner);

/// The words that a text property accepts: {"fast", "slow"}.
class Choices {
 public:
  /// Accepts any text.
  Choices() noexcept = default;
  /// Accepts only these words.
  Choices(std::initializer_list<std::string> words) : words_(words) {}
  /// True if there are no words, so that any text is accepted.
  [[nodiscard]] bool empty() const noexcept { return words_.empty(); }
  /// True if `word` is one of the words. The comparison is exact.
  [[nodiscard]] bool contain(std::string_view word) const noexcept;
  /// The words as text: "fast, medium or slow".
  [[nodiscard]] std::string text() const;

 private:
  std::vector<std::string> words_;
};

namespace detail {
/// Registers a property without a component. In a process module, the property takes its value from the
/// arguments.
void add_loose_property(PropertyBase& property);
void remove_loose_property(PropertyBase& property) noexcept;

std::optional<bool> parse_bool(std::string_view text) noexcept;
std::optional<std::int64_t> parse_integer(std::string_view text) noexcept;
std::optional<double> parse_number(std::string_view text) noexcept;
/// Returns the shortest text that reads back as the same value. The text of a float can be shorter than the
/// text of the same number as a double: 0.1F becomes "0.1".
std::string number_text(double value);
std::string number_text(float value);
}  // namespace detail

/// The types that a property can have.
template <class T>
concept PropertyValueType = std::same_as<T, bool> || std::same_as<T, std::string> || std::same_as<T, float> ||
    std::same_as<T, double> || std::signed_integral<T>;

/// A property of type bool, signed integer, float, double or std::string. Every hook may read the property,
/// including on the real-time thread. A service handler must not read it. If the value is set while the
/// component runs, the next call of a hook reads the new value. Takt does not call initialize() again, so
/// values computed in initialize() do not change.
template <class T>
class Property : public PropertyBase {
  static_assert(
      PropertyValueType<T>,
      "the type of a property is bool, a signed integer, float, double or std::string; for a text, write "
      "takt::Property<std::string>");

 public:
  /// The options of the property.
  struct Options {
    std::string unit{};      ///< unit of the value, such as "mm/s"; only for display and messages
    std::optional<T> min{};  ///< smallest accepted value; only for numbers
    std::optional<T> max{};  ///< largest accepted value; only for numbers
    std::string text{};      ///< one sentence for `takt describe`
    Choices choices{};       ///< the accepted words; text properties only; empty: any text
  };

  /// Constructs a property of a component, as a member. `value`: the default. Allocates memory, so not for
  /// real-time threads.
  Property(detail::Owner owner, std::string name, T value, Options options = {})
      : Property(owner.component(), std::move(name), std::move(value), std::move(options)) {}
  /// Constructs a property of a process module, as a global variable. Allocates memory.
  Property(std::string name, T value, Options options = {})
      : Property(nullptr, std::move(name), std::move(value), std::move(options)) {
    static_assert(detail::InProgram<T>,
                  "pass *this as the first argument: takt::Property<double> gain{*this, \"gain\", 1.0}; "
                  "only a program, which includes <takt/process.hpp>, omits it");
    detail::add_loose_property(*this);
  }

  /// Returns the value. A real-time thread may call it.
  operator const T&() const noexcept { return value_; }  // NOLINT(google-explicit-constructor)
  /// Returns the value. A real-time thread may call it.
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

  /// Narrows the declared range for this module, for example because of its period. Call narrow() in
  /// initialize(). It never widens the range. `why` follows the range in messages: "at a period of 1 ms".
  /// Fails if the current value is out of the new range; values that are set later are checked against the
  /// new range. Not for real-time threads.
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
    else if constexpr (std::is_same_v<T, std::string>)
      return value;
    else
      return {};  // the assertion above has failed; this branch prevents further errors
  }

  std::optional<T> accepted(std::string_view text) const {
    std::optional<T> value = parse(text);
    if constexpr (std::is_arithmetic_v<T>) {
      // The negated comparisons are true for NaN, so a bound rejects NaN.
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
      // A float property rejects a value that is too large for a float.
      return value && std::abs(*value) <= static_cast<double>(std::numeric_limits<T>::max())
                 ? std::optional<T>(static_cast<T>(*value))
                 : std::nullopt;
    } else if constexpr (std::is_same_v<T, std::string>) {
      return std::string{text};
    } else {
      return std::nullopt;
    }
  }

  const T default_;
  T value_;        // owned by the thread that calls hooks
  T passed_on_{};  // owned by the setting thread until take_over(); then it is the former value
  T set_last_;     // owned by the setting thread
  std::optional<T> min_;
  std::optional<T> max_;
  Choices choices_;
  std::string narrowed_;  // the reason given to narrow()
};

}  // namespace takt
