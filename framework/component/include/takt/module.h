/* The interface of a thread module (.so) in the form of the paper's Figures 8 and 10:
 *
 *   void initialize(irp::Property const& property);   or  void initialize(void);
 *   void start(void);
 *   void run(void);            every period, or when condition() holds, on the real-time thread
 *   int  condition(void);      sporadic modules: TRUE when run() is to be called; on the real-time thread
 *   void error(int type);      after an error took the module out of its table; type is one of TAKT_ERROR_...
 *   void recover(void);        to make it fit to run again
 *   void destruct(void);
 *
 * all with C linkage. Only run() is required (and condition() of a sporadic module); a hook that is not there
 * is taken as empty. run() and condition() are called by a real-time thread and must not lock, allocate,
 * block or log; all others by a thread that is not real-time. A hook reports failure by takt_fail(text) or,
 * in C++, by throwing. */
#ifndef TAKT_MODULE_H
#define TAKT_MODULE_H

#include <stdint.h>

#include <takt/port.h>
#include <takt/property.h>
#include <takt/saved.h>
#include <takt/text.h>

#ifndef TRUE
#define TRUE 1
#endif
#ifndef FALSE
#define FALSE 0
#endif

/* What error(int type) is told. */
enum {
  TAKT_ERROR_FAILURE = 1,  /* run() or condition() threw or called takt_fail() */
  TAKT_ERROR_BUDGET = 2,   /* one run() took longer than <budget> */
  TAKT_ERROR_START = 3,    /* start() failed */
  TAKT_ERROR_CRASH = 4,    /* the process module crashed or ended by itself */
  TAKT_ERROR_HANG = 5,     /* the process module did not come back from its body */
  TAKT_ERROR_DEADLINE = 6, /* a sporadic module was not done by its deadline, with miss="error" */
  TAKT_ERROR_STALE = 7,    /* an input is older than its connection's deadline, with stale="error" */
  TAKT_ERROR_OVERRUN = 8   /* a release was not served in time, and the descriptor calls that an error */
};

#ifdef __cplusplus
extern "C" {
#endif

/* Says that the hook which calls it failed, and why (at most 255 bytes are kept). Returns; the hook ends by
 * itself. From any hook, also from a real-time one: no lock, no allocation. Links with libtakt_component,
 * which the host has loaded. */
void takt_fail(const char* text);

/* The release that run() serves: its place in the module's grid, counting from 0 with gaps where releases
 * were missed; its instant in nanoseconds of CLOCK_MONOTONIC, P_n of the paper's Eq. (1); 0 outside of run().
 * Only on the thread that calls the hook. Real-time. */
uint64_t takt_cycle(void);
int64_t takt_release_ns(void);
/* The module's period in nanoseconds, in every hook; 0 when it has none, and of the executor's rows in run()
 * and condition() of a sporadic module. On the thread that calls the hook. Real-time. */
int64_t takt_period_ns(void);

#ifdef __cplusplus
}

#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

namespace irp {

/* The <property> of a module: named values as they stand in the descriptor. Not for real-time threads: read
 * what is needed in initialize(). */
class Property {
 public:
  using Values = std::vector<std::pair<std::string, std::string>>;

  Property() = default;
  explicit Property(Values values) : values_(std::move(values)) {}

  bool contains(const std::string& name) const { return find(name) != nullptr; }

  /* The text of a value. Throws std::out_of_range when the descriptor does not give it. */
  const std::string& get(const std::string& name) const {
    const std::string* text = find(name);
    if (text == nullptr) throw std::out_of_range("the descriptor gives no property '" + name + "'");
    return *text;
  }

  /* The value as bool (true, false, 1, 0), integer, floating point or std::string; `fallback` when the
   * descriptor does not give it. Throws std::invalid_argument when the text is none or does not fit: "1.5"
   * for an integer, "-1" for an unsigned one, "nan", a blank. */
  template <class T>
  T get(const std::string& name, T fallback) const {
    const std::string* text = find(name);
    return text == nullptr ? fallback : convert<T>(name, *text);
  }
  std::string get(const std::string& name, const char* fallback) const {
    const std::string* text = find(name);
    return text == nullptr ? fallback : *text;
  }

  /* The same for a number that must lie from `min` to `max`, both inclusive. */
  template <class T>
  T get(const std::string& name, T fallback, std::common_type_t<T> min, std::common_type_t<T> max) const {
    const std::string* text = find(name);
    if (text == nullptr) return fallback;
    const T value = convert<T>(name, *text);
    if (!(value >= min && value <= max)) refuse(name, *text, in_words(min) + " to " + in_words(max));
    return value;
  }

  /* In the order of the descriptor. */
  const Values& values() const { return values_; }

 private:
  const std::string* find(const std::string& name) const {
    for (const auto& value : values_) {
      if (value.first == name) return &value.second;
    }
    return nullptr;
  }

  [[noreturn]] static void refuse(const std::string& name, const std::string& text,
                                  const std::string& wanted) {
    throw std::invalid_argument("property '" + name + "' is '" + text + "'; it takes " + wanted);
  }

  template <class T>
  static std::string in_words(T value) {
    char text[64];
    return {text, std::to_chars(text, text + sizeof text, value).ptr};
  }

  template <class T>
  static T convert(const std::string& name, const std::string& text) {
    if constexpr (std::is_same_v<T, bool>) {
      if (text == "true" || text == "1") return true;
      if (text != "false" && text != "0") refuse(name, text, "true or false");
      return false;
    } else if constexpr (std::is_arithmetic_v<T>) {
      // Not strtod(): it follows the locale, skips blanks and takes hexadecimal, so one text would mean
      // different numbers.
      T value{};
      const char* const end = text.data() + text.size();
      const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
      const auto [stop, error] = std::from_chars(text.data() + (plus ? 1 : 0), end, value);
      const bool whole = error == std::errc{} && stop == end;
      if constexpr (std::is_floating_point_v<T>) {
        if (!whole || !std::isfinite(value)) refuse(name, text, "a number");
      } else {
        constexpr T lowest = std::numeric_limits<T>::min();
        constexpr T highest = std::numeric_limits<T>::max();
        if (!whole) refuse(name, text, "a whole number, " + in_words(lowest) + " to " + in_words(highest));
      }
      return value;
    } else {
      static_assert(std::is_same_v<T, std::string>,
                    "a property is bool, integer, floating point or std::string");
      return text;
    }
  }

  Values values_;
};

}  // namespace irp
#endif

#endif
