/** @file
 * Ports for modules in the C form: thread modules (.so) and process modules (.exe). Declare them at file
 * scope, each with a type that takt_add_idl() generated:
 *
 *     #include <takt/module.h>          or <takt/process.h>
 *     #include <motion_c.h>
 *
 *     TAKT_IN_PORT(motion_JointState, measured);
 *     TAKT_EVENT_PORT(motion_PickRequest, request);    makes a sporadic module ready to run
 *     TAKT_OUT_PORT(motion_JointEffort, effort);
 *
 *     void run(void) {
 *       motion_JointState state;
 *       if (takt_read(&measured, &state)) ...
 *       takt_write(&effort, &output);
 *     }
 *
 * Every hook may call these macros, including on the real-time thread: they neither wait nor allocate. Only
 * one thread may call them at a time. In a process module, use them only after initPeriodExe() or
 * initSporadicExe(). An unconnected input never has a new sample, and an unconnected output discards its
 * samples. */
#ifndef TAKT_PORT_H
#define TAKT_PORT_H

#include <stdint.h>

#include <takt/type.h>

/** The direction of a port. */
enum takt_direction {
  TAKT_IN,    /**< an input */
  TAKT_EVENT, /**< an input whose samples make a sporadic module ready to run */
  TAKT_OUT    /**< an output */
};

/** A port, as the macros below declare it. */
typedef struct takt_port {
  const char* name;              /**< the name of the port */
  const takt_type* type;         /**< the type of its samples */
  enum takt_direction direction; /**< its direction */
  void* inside;                  /**< the port's object in Takt; set when the module is loaded */
} takt_port;

#ifdef __cplusplus
extern "C" {
#endif

/* The macros below call these functions. */
void takt_add_port(takt_port* port);
void takt_remove_port(takt_port* port);
int takt_port_read(takt_port* port, void* value);
int takt_port_write(takt_port* port, const void* value);
int takt_port_has_news(const takt_port* port);
int takt_port_is_new(const takt_port* port);
int takt_port_is_safe(const takt_port* port);
int takt_port_connected(const takt_port* port);
uint64_t takt_port_sequence(const takt_port* port);
int64_t takt_port_age_ns(const takt_port* port);

#ifdef __cplusplus
}
#endif

/** Declares an input. `Type`: a struct that takt_add_idl() generated; `port`: the name. At file scope. */
#define TAKT_IN_PORT(Type, port) TAKT_PORT_OF_DIRECTION(Type, port, TAKT_IN)
/** Declares an event input, whose samples make a sporadic module ready to run. At file scope. */
#define TAKT_EVENT_PORT(Type, port) TAKT_PORT_OF_DIRECTION(Type, port, TAKT_EVENT)
/** Declares an output. At file scope. */
#define TAKT_OUT_PORT(Type, port) TAKT_PORT_OF_DIRECTION(Type, port, TAKT_OUT)

/** Takes the next sample and returns 1: the newest if the connection holds the latest value, the oldest if it
 * is a queue. Returns 0 if no sample has arrived. In both cases it copies the sample that was read last to
 * *value; before the first sample, *value becomes all zero. A safe value arrives like a sample: once, when it
 * replaces the last sample. A real-time thread may call it. */
#define takt_read(port, value) takt_port_read(TAKT_INPUT(port), TAKT_VALUE_OF(port, value))
/** Sends *value to all connected readers and returns 1, even if there are none. Returns 0 if the value does
 * not fit its type: a length exceeds its bound, or an enumerator is invalid. The stamp of the sample is the
 * start of the current run(). A real-time thread may call it. */
#define takt_write(port, value) takt_port_write(TAKT_OUTPUT(port), TAKT_VALUE_OF(port, value))
/** Returns 1 if takt_read() would find a sample, otherwise 0. A real-time thread may call it. */
#define takt_has_news(port) takt_port_has_news(TAKT_INPUT(port))
/** Returns 1 if the last takt_read() found a sample, otherwise 0. A real-time thread may call it. */
#define takt_is_new(port) takt_port_is_new(TAKT_INPUT(port))
/** Returns 1 if the value of the last takt_read() is the safe value of the connected output, otherwise 0. A
 * real-time thread may call it. */
#define takt_is_safe(port) takt_port_is_safe(TAKT_INPUT(port))
/** Returns 1 if the port is connected to another port, otherwise 0. A real-time thread may call it. */
#define takt_connected(port) takt_port_connected(&(port)->base)
/** Returns the sequence number of the sample that was read last; 0 before the first sample. The writer
 * numbers its samples from 1. A real-time thread may call it. */
#define takt_sequence(port) takt_port_sequence(TAKT_INPUT(port))
/** Returns the age, in ns, of the sample that was read last: the time from the start of the run() that wrote
 * it to the start of this run(). INT64_MAX before the first sample. A real-time thread may call it. */
#define takt_age_ns(port) takt_port_age_ns(TAKT_INPUT(port))

/* Makes the compiler reject a pointer to a type other than that of the port, and a port of the wrong
 * direction. In C, these are assertions, because the compiler reports no warnings for macros of installed
 * headers. */
#ifdef __cplusplus
#define TAKT_VALUE_OF(port, pointer) (1 ? (pointer) : (port)->value)
#define TAKT_BASE_IF(condition, text, port) (&(port)->base + 0 * sizeof(char[(condition) ? 1 : -1]))
#else
#define TAKT_VALUE_OF(port, pointer)                                                                   \
  ((pointer) + 0 * sizeof(struct {                                                                     \
                 _Static_assert(                                                                       \
                     __builtin_types_compatible_p(__typeof__(*(pointer)), __typeof__(*(port)->value)), \
                     "the second argument must point to a value of the type of this port");            \
                 int unused;                                                                           \
               }))
#define TAKT_BASE_IF(condition, text, port)           \
  (&(port)->base + 0 * sizeof(struct {                \
                     _Static_assert(condition, text); \
                     int unused;                      \
                   }))
#endif
#define TAKT_INPUT(port)                                   \
  TAKT_BASE_IF(sizeof(*(port)->direction) != 1 + TAKT_OUT, \
               "the first argument must be an input: TAKT_IN_PORT or TAKT_EVENT_PORT", port)
#define TAKT_OUTPUT(port)                                  \
  TAKT_BASE_IF(sizeof(*(port)->direction) == 1 + TAKT_OUT, \
               "the first argument must be an output: TAKT_OUT_PORT", port)

#define TAKT_PORT_OF_DIRECTION(Type, port, direction_)                                               \
  static struct {                                                                                    \
    takt_port base;                                                                                  \
    Type* value;                                                                                     \
    char (*direction)[1 + direction_];                                                               \
  } port = {{#port, &Type##_type, direction_, 0}, 0, 0};                                             \
  static void __attribute__((constructor)) takt_add_##port(void) { takt_add_port(&port.base); }      \
  static void __attribute__((destructor)) takt_remove_##port(void) { takt_remove_port(&port.base); } \
  struct takt_port_##port

#endif
