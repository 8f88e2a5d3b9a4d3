// The result of a call that may fail for a reason outside the program: a value or a list of problems. It is a
// list because a descriptor may have a hundred mistakes, and its author wants to see all of them at once.
#pragma once

#include <string>
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

  /// Compares all three texts.
  bool operator==(const Problem&) const = default;
};

/// A list of problems.
using Problems = std::vector<Problem>;

/// The problem as one line without a line feed: "WHERE: error: WHAT; FIX". Empty parts are omitted.
std::string to_text(const Problem& problem);
/// The problems as text, one line for each problem.
std::string to_text(const Problems& problems);
/// The problems for use within a sentence, all on one line: "WHERE: WHAT; FIX", separated by ". ".
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

  /// Returns the value. If there is none, ends the process.
  T& value() & {
    TAKT_CHECK(ok());
    return std::get<0>(outcome_);
  }
  /// Returns the value. If there is none, ends the process.
  const T& value() const& {
    TAKT_CHECK(ok());
    return std::get<0>(outcome_);
  }
  /// Returns the value. If there is none, ends the process.
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

  /// Returns the problems, at least one. May be called only if ok() is false.
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

  /// Returns true if the call succeeded.
  [[nodiscard]] bool ok() const noexcept { return problems_.empty(); }
  /// Same as ok().
  explicit operator bool() const noexcept { return ok(); }
  /// Returns the problems; the list is empty if ok() is true.
  [[nodiscard]] const Problems& problems() const { return problems_; }

 private:
  Problems problems_;
};

/// Creates a problem in one line: `return fail("the sensor does not answer", "switch it on");`. `what` states
/// what is wrong; `fix` states what to do, and may be omitted. Not for real-time threads, because it
/// allocates memory.
[[nodiscard("return it; otherwise the failure is lost")]] inline Problem fail(std::string what,
                                                                              std::string fix = {}) {
  return {{}, std::move(what), std::move(fix)};
}

}  // namespace takt
