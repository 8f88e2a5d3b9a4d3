// The result of a call that can fail for a reason outside the program: a value, or a list of problems. A
// descriptor can have a hundred mistakes, and its author wants to see all of them at once.
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <takt/core/check.hpp>

namespace takt {

/// One thing that is wrong, worded for the person who has to fix it.
struct Problem {
  std::string where;  ///< "deploy/module.xml:12", "module servo"; may be empty
  std::string what;   ///< what is wrong
  std::string fix;    ///< what to do; may be empty

  /// Compares all three texts.
  bool operator==(const Problem&) const = default;
};

/// A list of problems.
using Problems = std::vector<Problem>;

/// "WHERE: error: WHAT; FIX"; empty parts are left out. One line, without a line feed at its end.
std::string to_text(const Problem& problem);
/// Calls to_text() for each problem and puts each result on a line of its own.
std::string to_text(const Problems& problems);
/// "WHERE: WHAT; FIX" for use within a sentence: all problems on one line, separated by ". ".
std::string in_words(const Problems& problems);

/// A value or a list of problems. Not for real-time threads: problems allocate.
template <class T>
class [[nodiscard]] Result {
 public:
  /// Success, with a value.
  Result(T value) : outcome_(std::move(value)) {}  // NOLINT(google-explicit-constructor)
  /// A failure. The list must not be empty.
  Result(Problems problems) : outcome_(std::move(problems)) {
    TAKT_CHECK(!this->problems().empty());
  }  // NOLINT
  /// A failure with one problem.
  Result(Problem problem) : outcome_(Problems{std::move(problem)}) {}  // NOLINT

  /// Whether there is a value.
  [[nodiscard]] bool ok() const noexcept { return outcome_.index() == 0; }
  /// The same as ok().
  explicit operator bool() const noexcept { return ok(); }

  /// The value. Only if ok(); otherwise the process ends.
  T& value() & {
    TAKT_CHECK(ok());
    return std::get<0>(outcome_);
  }
  /// The value. Only if ok(); otherwise the process ends.
  const T& value() const& {
    TAKT_CHECK(ok());
    return std::get<0>(outcome_);
  }
  /// The value. Only if ok(); otherwise the process ends.
  T&& value() && {
    TAKT_CHECK(ok());
    return std::get<0>(std::move(outcome_));
  }
  /// The same as value().
  T& operator*() { return value(); }
  /// The same as value().
  const T& operator*() const { return value(); }
  /// The address of value().
  T* operator->() { return &value(); }
  /// The address of value().
  const T* operator->() const { return &value(); }

  /// The problems, at least one. Only if not ok().
  [[nodiscard]] const Problems& problems() const { return std::get<1>(outcome_); }

 private:
  std::variant<T, Problems> outcome_;
};

/// Success without a value, or a list of problems.
template <>
class [[nodiscard]] Result<void> {
 public:
  /// Success.
  Result() = default;
  /// A failure. The list must not be empty.
  Result(Problems problems) : problems_(std::move(problems)) { TAKT_CHECK(!problems_.empty()); }  // NOLINT
  /// A failure with one problem.
  Result(Problem problem) : problems_{std::move(problem)} {}  // NOLINT

  /// Whether the call succeeded.
  [[nodiscard]] bool ok() const noexcept { return problems_.empty(); }
  /// The same as ok().
  explicit operator bool() const noexcept { return ok(); }
  /// The problems; empty if ok().
  [[nodiscard]] const Problems& problems() const { return problems_; }

 private:
  Problems problems_;
};

/// A failure in one line: `return fail("the sensor does not answer", "switch it on");`. The arguments are
/// what is wrong, and what to do, which may be left out. Not real-time: allocates.
[[nodiscard("return it; otherwise the failure is lost")]] inline Problem fail(std::string what,
                                                                              std::string fix = {}) {
  return {{}, std::move(what), std::move(fix)};
}

}  // namespace takt
