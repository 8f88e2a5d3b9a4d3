// What a call returns that can fail for a reason of the world: a value, or everything that is wrong. A caller
// with a descriptor of a hundred mistakes wants all hundred, so a failure is a list.
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <takt/core/check.hpp>

namespace takt {

/// One thing that is wrong, in the words of the person who must mend it.
struct Problem {
  std::string where;  ///< "deploy/module.xml:12", "module servo"; may be empty
  std::string what;   ///< what is wrong
  std::string fix;    ///< what would be right; may be empty

  bool operator==(const Problem&) const = default;
};

using Problems = std::vector<Problem>;

/// "WHERE: error: WHAT; FIX", without what is empty. One line, no line feed.
std::string to_text(const Problem& problem);
/// The same for each problem, one a line.
std::string to_text(const Problems& problems);
/// "WHERE: WHAT; FIX", for use within a sentence: one problem after the other, in one line.
std::string in_words(const Problems& problems);

/// A value or problems. Not for real-time threads: problems allocate.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : outcome_(std::move(value)) {}  // NOLINT(google-explicit-constructor)
  Result(Problems problems) : outcome_(std::move(problems)) {
    TAKT_CHECK(!this->problems().empty());
  }                                                                    // NOLINT
  Result(Problem problem) : outcome_(Problems{std::move(problem)}) {}  // NOLINT

  [[nodiscard]] bool ok() const noexcept { return outcome_.index() == 0; }
  explicit operator bool() const noexcept { return ok(); }

  /// Only when ok().
  T& value() & {
    TAKT_CHECK(ok());
    return std::get<0>(outcome_);
  }
  const T& value() const& {
    TAKT_CHECK(ok());
    return std::get<0>(outcome_);
  }
  T&& value() && {
    TAKT_CHECK(ok());
    return std::get<0>(std::move(outcome_));
  }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  /// Only when not ok(); never empty.
  [[nodiscard]] const Problems& problems() const { return std::get<1>(outcome_); }

 private:
  std::variant<T, Problems> outcome_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Problems problems) : problems_(std::move(problems)) { TAKT_CHECK(!problems_.empty()); }  // NOLINT
  Result(Problem problem) : problems_{std::move(problem)} {}                                      // NOLINT

  [[nodiscard]] bool ok() const noexcept { return problems_.empty(); }
  explicit operator bool() const noexcept { return ok(); }
  [[nodiscard]] const Problems& problems() const { return problems_; }

 private:
  Problems problems_;
};

/// A failure in one line: `return fail("the sensor does not answer", "switch it on");`
[[nodiscard("return it: nobody hears of it otherwise")]] inline Problem fail(std::string what,
                                                                             std::string fix = {}) {
  return {{}, std::move(what), std::move(fix)};
}

}  // namespace takt
