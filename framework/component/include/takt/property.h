/* Properties of modules in the C form, thread module (.so) or program (.exe). At file scope, each with its
 * default:
 *
 *   #include <takt/module.h>          or <takt/process.h>
 *
 *   TAKT_NUMBER(gain, 60, 1, 200, "1/s", "Proportional gain.");            static double gain
 *   TAKT_INTEGER(counter, 5, 1, 1000000, "periods", "How many to wait.");  static int64_t counter
 *   TAKT_FLAG(enabled, 1, "Whether the drive is on.");                     static int enabled, 0 or 1
 *   TAKT_STRING(label, "none", "Shown to the operator.");                  static const char* label
 *
 * A number lies from its minimum to its maximum, both inclusive; -INFINITY and INFINITY, INT64_MIN and
 * INT64_MAX are no bounds. The value is that of the descriptor: in a thread module from initialize() on, and
 * where `takt set` gives it another one, from the next call of a hook on; in a program from the first line of
 * main() on, for good.
 *
 * A module that declares a property has no others: what the descriptor says beside them, or out of range, is
 * refused by `takt check`, and again when the module starts. One that declares none takes any, and looks at
 * them itself. */
#ifndef TAKT_PROPERTY_H
#define TAKT_PROPERTY_H

#include <stdint.h>

enum takt_property_type { TAKT_IS_FLAG, TAKT_IS_INTEGER, TAKT_IS_NUMBER, TAKT_IS_STRING };

typedef struct takt_property {
  const char* name;
  enum takt_property_type type;
  void* value; /* the variable; it holds the default */
  double min, max;
  int64_t least, most;
  const char* unit;
  const char* text;
  void* inside; /* set when the module is loaded */
} takt_property;

#ifdef __cplusplus
extern "C" {
#endif

/* What the macros below call. */
void takt_add_property(takt_property* property);
void takt_remove_property(takt_property* property);

#ifdef __cplusplus
}
#endif

#define TAKT_NUMBER(name, value, min, max, unit, text) \
  static double name = value;                          \
  TAKT_PROPERTY(name, TAKT_IS_NUMBER, min, max, 0, 0, unit, text)
#define TAKT_INTEGER(name, value, min, max, unit, text) \
  static int64_t name = value;                          \
  TAKT_PROPERTY(name, TAKT_IS_INTEGER, 0, 0, min, max, unit, text)
#define TAKT_FLAG(name, value, text) \
  static int name = value;           \
  TAKT_PROPERTY(name, TAKT_IS_FLAG, 0, 0, 0, 0, "", text)
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
