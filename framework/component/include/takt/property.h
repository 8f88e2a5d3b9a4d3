/** @file
 * Properties of modules in the C form: thread modules (.so) and process modules (.exe). Declare them at file
 * scope, each with its default:
 *
 *     #include <takt/module.h>          or <takt/process.h>
 *
 *     TAKT_NUMBER(gain, 60, 1, 200, "1/s", "Proportional gain.");            static double gain
 *     TAKT_INTEGER(counter, 5, 1, 1000000, "periods", "How many to wait.");  static int64_t counter
 *     TAKT_FLAG(enabled, 1, "Whether the drive is on.");                     static int enabled, 0 or 1
 *     TAKT_STRING(label, "none", "Shown to the operator.");                  static const char* label
 *
 * The arguments of a number are: name, default, minimum, maximum, unit, text. Both bounds are inclusive.
 * -INFINITY and INFINITY, or INT64_MIN and INT64_MAX, mean no bound. The text is one sentence for
 * `takt describe`.
 *
 * The variable has the value of the descriptor: in a thread module from initialize() on, in a process module
 * from the first line of main() on. After `takt set`, the next hook or the next body sees the new value. Read
 * the variable only in the thread that calls the hooks, or waitPeriod(). This thread may be real-time.
 *
 * If a module declares properties, `takt check` rejects other names in the descriptor, and values out of
 * range. Takt rejects them also when the module starts. A module that declares no properties accepts any name
 * and value, and must check them itself. The name `log-level` is reserved: this property of every module sets
 * the level of its log, and the module does not receive it. */
#ifndef TAKT_PROPERTY_H
#define TAKT_PROPERTY_H

#include <stdint.h>

/** The type of a property. */
enum takt_property_type {
  TAKT_IS_FLAG,    /**< int, 0 or 1 */
  TAKT_IS_INTEGER, /**< int64_t */
  TAKT_IS_NUMBER,  /**< double */
  TAKT_IS_STRING   /**< const char* */
};

/** A property, as the macros below declare it. */
typedef struct takt_property {
  const char* name;             /**< the name of the property */
  enum takt_property_type type; /**< its type */
  void* value;                  /**< the variable; it holds the default */
  double min;                   /**< smallest value of a number; not finite: no bound */
  double max;                   /**< largest value of a number; not finite: no bound */
  int64_t least;                /**< smallest value of an integer; INT64_MIN: no bound */
  int64_t most;                 /**< largest value of an integer; INT64_MAX: no bound */
  const char* unit;             /**< the unit, such as "m/s"; may be empty */
  const char* text;             /**< one sentence for `takt describe` */
  void* inside;                 /**< the property's object in Takt; set when the module is loaded */
} takt_property;

#ifdef __cplusplus
extern "C" {
#endif

/* The macros below call these functions. */
void takt_add_property(takt_property* property);
void takt_remove_property(takt_property* property);

#ifdef __cplusplus
}
#endif

/** Declares a property `static double name`. At file scope. */
#define TAKT_NUMBER(name, value, min, max, unit, text) \
  static double name = value;                          \
  TAKT_PROPERTY(name, TAKT_IS_NUMBER, min, max, 0, 0, unit, text)
/** Declares a property `static int64_t name`. At file scope. */
#define TAKT_INTEGER(name, value, min, max, unit, text) \
  static int64_t name = value;                          \
  TAKT_PROPERTY(name, TAKT_IS_INTEGER, 0, 0, min, max, unit, text)
/** Declares a property `static int name`, which is 0 or 1. At file scope. */
#define TAKT_FLAG(name, value, text) \
  static int name = value;           \
  TAKT_PROPERTY(name, TAKT_IS_FLAG, 0, 0, 0, 0, "", text)
/** Declares a property `static const char* name`. At file scope. */
#define TAKT_STRING(name, value, text) \
  static const char* name = value;     \
  TAKT_PROPERTY(name, TAKT_IS_STRING, 0, 0, 0, 0, "", text)

#define TAKT_PROPERTY(name, type, min, max, least, most, unit, text)                                      \
  static takt_property takt_property_##name = {#name, type, &name, min, max, least, most, unit, text, 0}; \
  static void __attribute__((constructor)) takt_add_##name(void) {                                        \
    takt_add_property(&takt_property_##name);                                                             \
  }                                                                                                       \
  static void __attribute__((destructor)) takt_remove_##name(void) {                                      \
    takt_remove_property(&takt_property_##name);                                                          \
  }                                                                                                       \
  struct takt_property_of_##name

#endif
