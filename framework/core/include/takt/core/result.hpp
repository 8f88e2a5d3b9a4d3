// The result of a call that may fail for a reason outside Takt's code: a value or a list of problems.
// Problems form a list, because a descriptor may have a hundred mistakes, and its author wants to see all of
// them at once.
#pragma once

#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <takt/core/check.hpp>

namespace takt {

/// One problem, worded for the person who must solve it.
struct Problem {
  std::string where;  ///< the place of the problem, for example "deploy/module.xml:12" or "module servo"; may
                      ///< be empty
  std::string what;   ///< what is wrong
  std::string fix;    ///< what to do; may be empty

  /// True if the texts `where`, `what` and `fix` of both problems are equal.
  bool operator==(const Problem&) const = default;
};

/// A list of problems.
using Problems = std::vector<Problem>;

/// Returns the problem as one line: "WHERE: error: WHAT; FIX". Empty parts are omitted. Control characters
/// are escaped, because a part may be the text of a component.
std::string to_text(const Problem& problem);
/// Returns the problems as text, one line for each problem.
std::string to_text(const Problems& problems);
/// Returns all problems on one line, for use within a sentence. Each problem is "WHERE: WHAT; FIX", and ". "
/// separates two problems. Control characters are escaped.
std::string in_words(const Problems& problems);

/// A value or a list of problems. Not for real-time threads, because problems allocate memory.
template <class T>
class [[nodiscard]] Result {
 public:
  /// Creates a success with a value.
  Result(T value) : outcome_(std::move(value)) {}  // NOLINT(google-explicit-constructor)
  /// Creates a failure. The list must not be empty.
  Result(Problems problems) : outcome_(std::move(problems)) {
    TAKT_CHECK(!this->problems().empty());
  }  // NOLINT
  /// Creates a failure with one problem.
  Result(Problem problem) : outcome_(Problems{std::move(problem)}) {}  // NOLINT

  /// Returns true if there is a value.
  [[nodiscard]] bool ok() const noexcept { return outcome_.index() == 0; }
  /// Same as ok().
  explicit operator bool() const noexcept { return ok(); }

  /// Returns the value. Aborts the process if there is no value.
  T& value() & {
    TAKT_CHECK(ok());
    return std::get<0>(outcome_);
  }
  /// Returns the value. Aborts the process if there is no value.
  const T& value() const& {
    TAKT_CHECK(ok());
    return std::get<0>(outcome_);
  }
  /// Returns the value. Aborts the process if there is no value.
  T&& value() && {
    TAKT_CHECK(ok());
    return std::get<0>(std::move(outcome_));
  }
  /// Same as value().
  T& operator*() { return value(); }
  /// Same as value().
  const T& operator*() const { return value(); }
  /// Returns the address of value().
  T* operator->() { return &value(); }
  /// Returns the address of value().
  const T* operator->() const { return &value(); }

  /// Returns the problems, at least one. Call this function only if ok() is false.
  [[nodiscard]] const Problems& problems() const { return std::get<1>(outcome_); }

 private:
  std::variant<T, Problems> outcome_;
};

/// A success without a value, or a list of problems.
template <>
class [[nodiscard]] Result<void> {
 public:
  /// Creates a success.
  Result() = default;
  /// Creates a failure. The list must not be empty.
  Result(Problems problems) : problems_(std::move(problems)) { TAKT_CHECK(!problems_.empty()); }  // NOLINT
  /// Creates a failure with one problem.
  Result(Problem problem) : problems_{std::move(problem)} {}  // NOLINT
  /// Makes the compiler reject `return false;`, or the return of a number or a text, with a message that
  /// states what to return instead.
  template <class T,
            class = std::enable_if_t<std::is_arithmetic_v<T> || std::is_convertible_v<T, std::string>>>
  Result(T /*value*/) {  // NOLINT
    static_assert(
        std::is_void_v<T>,
        "for success, return {}; for a failure, return takt::fail(\"what is wrong\", \"what to do\")");
  }

  /// Returns true if the call succeeded.
  [[nodiscard]] bool ok() const noexcept { return problems_.empty(); }
  /// Same as ok().
  explicit operator bool() const noexcept { return ok(); }
  /// Returns the problems; the list is empty if ok() is true.
  [[nodiscard]] const Problems& problems() const { return problems_; }

 private:
  Problems problems_;
};

/// Creates a problem, for a return statement: `return fail("the sensor does not answer", "switch it on");`.
/// `what` states what is wrong; `fix` states what to do, and may be omitted. Not for real-time threads,
/// because this function allocates memory.
[[nodiscard("return it; otherwise the failure is lost")]] inline Problem fail(std::string what,
                                                                              std::string fix = {}) {
  return {{}, std::move(what), std::move(fix)};
}

}  // namespace takt
