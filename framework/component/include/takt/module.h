/** @file
 * The interface of a thread module (.so) in the form of the paper's Figures 8 and 10. The module defines
 * these functions, all with C linkage:
 *
 *     void initialize(irp::Property const& property);   or  void initialize(void);
 *     void start(void);
 *     void run(void);            every period, or when condition() returns TRUE
 *     int  condition(void);      sporadic modules: returns TRUE if run() must be called
 *     void error(int type);      after an error took the module out of its table; type is a TAKT_ERROR_...
 *     void recover(void);        prepares the module to run again
 *     void destruct(void);
 *
 * run() is required. A sporadic module without an event port also needs condition(). All other hooks are
 * optional. A real-time thread calls run() and condition(), which must not lock, allocate or block; they may
 * write log lines with takt_log(). Another thread, which is not real-time, calls all other hooks. A hook
 * reports a failure with takt_fail(text) or, in C++, by throwing an exception. */
#ifndef TAKT_MODULE_H
#define TAKT_MODULE_H

#ifdef TAKT_PROCESS_MODULE
#error <takt/module.h> is for components: use takt_add_component; a program includes <takt/process.h>
#endif

#include <stdint.h>

#include <takt/log.h>
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

/** The argument of error(int type): why the module was taken out of its table. */
enum {
  TAKT_ERROR_FAILURE = 1,  /**< run() or condition() threw or called takt_fail() */
  TAKT_ERROR_BUDGET = 2,   /**< one run() took longer than `<budget>` */
  TAKT_ERROR_START = 3,    /**< start() failed */
  TAKT_ERROR_CRASH = 4,    /**< the host or the process module crashed or ended by itself */
  TAKT_ERROR_HANG = 5,     /**< run() or another hook did not return */
  TAKT_ERROR_DEADLINE = 6, /**< a sporadic module missed its deadline, with miss="error" */
  TAKT_ERROR_STALE = 7,    /**< an input was older than its connection's deadline, with stale="error" */
  TAKT_ERROR_OVERRUN = 8   /**< a release was not served in time, and the descriptor makes that an error */
};

#ifndef __cplusplus
/* In C, a hook with another result does not compile, because Takt could not see the result. In C++, these
 * declarations would reject hooks that are noexcept. */
void initialize(void); /**< returns nothing; it reports a failure with takt_fail(text) */
void start(void);      /**< returns nothing; it reports a failure with takt_fail(text) */
void run(void);        /**< returns nothing; it reports a failure with takt_fail(text) */
int condition(void);   /**< returns TRUE or FALSE; it reports a failure with takt_fail(text) */
void recover(void);    /**< returns nothing; it reports a failure with takt_fail(text) */
void destruct(void);   /**< returns nothing; it reports a failure with takt_fail(text) */
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Reports that the calling hook failed, with a reason (at most 255 bytes are kept). takt_fail() returns to
 * the hook, which should then return, too. Any hook may call it. It takes no lock and allocates nothing, so a
 * real-time thread may call it. The function is in libtakt_component, which is loaded with the host. */
void takt_fail(const char* text);

/** Reports from run() that the module has finished its work. This run() is then the last one: Takt takes the
 * module out of its table, calls destruct(), and the module is in DESTRUCT until it is reset. takt_finish()
 * returns to run(), which should then return, too. If run() calls takt_finish() and fails, Takt treats it as
 * failed, not as finished. Outside of run(), takt_finish() has no effect. It takes no lock and allocates
 * nothing, so a real-time thread may call it. */
void takt_finish(void);

/** Returns the number of the release for which run() was called. Releases are numbered from 0; a missed
 * release leaves a gap. For a sporadic module, this is the number of the executor's row that released it
 * (with immediate dispatch, of the next row). Returns 0 outside of run(). Only the thread that runs the hook
 * may call it. A real-time thread may call it. */
uint64_t takt_cycle(void);
/** Returns the instant at which the release was due for which run() was called: P_n of the paper's Eq. (1),
 * in ns of CLOCK_MONOTONIC. Returns 0 outside of run(). Only the thread that runs the hook may call it. A
 * real-time thread may call it. */
int64_t takt_release_ns(void);
/** Returns the period of the module in ns, in every hook; 0 if the module has no period. In run() and
 * condition() of a sporadic module it is the basic period of the executor. Only the thread that runs the hook
 * may call it. A real-time thread may call it. */
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

/** The C++ types of the paper's interface. */
namespace irp {

/** The properties of a module: the named values of the descriptor. Real-time threads must not use this class;
 * read the properties in initialize(). */
class Property {
 public:
  /** Pairs of name and text. */
  using Values = std::vector<std::pair<std::string, std::string>>;

  /** Constructs an empty set of properties. */
  Property() = default;
  /** Constructs a set with the properties in `values`. */
  explicit Property(Values values) : values_(std::move(values)) {}

  /** True if the descriptor sets the property. */
  bool contains(const std::string& name) const { return find(name) != nullptr; }

  /** Returns the text of a property. Throws std::out_of_range if the descriptor does not set the property. */
  const std::string& get(const std::string& name) const {
    const std::string* text = find(name);
    if (text == nullptr) throw std::out_of_range("the descriptor does not set property '" + name + "'");
    return *text;
  }

  /** Returns the value of a property as bool (true, false, 1, 0), integer, floating point or std::string;
   * `fallback` if the descriptor does not set the property. Throws std::invalid_argument if the text is not a
   * value of type T, for example "1.5" for an integer, "-1" for an unsigned integer, "nan" or a blank. */
  template <class T>
  T get(const std::string& name, T fallback) const {
    const std::string* text = find(name);
    return text == nullptr ? fallback : convert<T>(name, *text);
  }
  /** Returns the text of a property; `fallback` if the descriptor does not set the property. */
  std::string get(const std::string& name, const char* fallback) const {
    const std::string* text = find(name);
    return text == nullptr ? fallback : *text;
  }

  /** Returns the value of a property that is a number from `min` to `max`, both inclusive; `fallback` if the
   * descriptor does not set the property. Throws std::invalid_argument if the value is out of this range or
   * is not a number. The fallback is not checked. */
  template <class T>
  T get(const std::string& name, T fallback, std::common_type_t<T> min, std::common_type_t<T> max) const {
    const std::string* text = find(name);
    if (text == nullptr) return fallback;
    const T value = convert<T>(name, *text);
    if (!(value >= min && value <= max)) refuse(name, *text, in_words(min) + " to " + in_words(max));
    return value;
  }

  /** All properties, in the order of the descriptor. */
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
      // This code does not use strtod(), which depends on the locale, skips blanks and accepts hexadecimal
      // numbers. So a text always means the same number.
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
