/* Ports of modules in the C form, thread module (.so) or program (.exe). At file scope, each with a type that
 * takt_add_idl() made:
 *
 *   #include <takt/module.h>          or <takt/process.h>
 *   #include <motion_c.h>
 *
 *   TAKT_IN_PORT(motion_JointState, measured);
 *   TAKT_EVENT_PORT(motion_PickRequest, request);    makes a sporadic module ready to run
 *   TAKT_OUT_PORT(motion_JointEffort, effort);
 *
 *   void run(void) {
 *     motion_JointState state;
 *     if (takt_read(&measured, &state)) ...
 *     takt_write(&effort, &output);
 *   }
 *
 * All of them are for every hook, also on the real-time thread: they neither wait nor allocate. One thread at
 * a time. In a program after initPeriodExe() or initSporadicExe(). A port that nobody is connected to never
 * has news, and writes nowhere. */
#ifndef TAKT_PORT_H
#define TAKT_PORT_H

#include <stdint.h>

#include <takt/type.h>

enum takt_direction { TAKT_IN, TAKT_EVENT, TAKT_OUT };

typedef struct takt_port {
  const char* name;
  const takt_type* type;
  enum takt_direction direction;
  void* inside; /* set when the module is loaded */
} takt_port;

#ifdef __cplusplus
extern "C" {
#endif

/* What the macros below call. */
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

#define TAKT_IN_PORT(Type, port) TAKT_PORT_OF_DIRECTION(Type, port, TAKT_IN)
#define TAKT_EVENT_PORT(Type, port) TAKT_PORT_OF_DIRECTION(Type, port, TAKT_EVENT)
#define TAKT_OUT_PORT(Type, port) TAKT_PORT_OF_DIRECTION(Type, port, TAKT_OUT)

/* Goes on to the next sample and returns 1: the newest of a connection that holds the latest value, the
 * oldest of a queue. Returns 0 when none has come. In either case *value is the last sample that was read,
 * all zero before the first. A safe value comes like a sample: once, when it takes the place of what was
 * there. */
#define takt_read(port, value) takt_port_read(&(port)->base, TAKT_VALUE_OF(port, value))
/* Returns 1, however many are connected; 0 when the value is none of the type: a length or an enumerator
 * beyond its bound. The sample's time is the beginning of the run() that it was written in. */
#define takt_write(port, value) takt_port_write(&(port)->base, TAKT_VALUE_OF(port, value))
/* takt_read() would find a sample. */
#define takt_has_news(port) takt_port_has_news(&(port)->base)
/* The last takt_read() found one. */
#define takt_is_new(port) takt_port_is_new(&(port)->base)
/* What takt_read() gave last is the safe value of the output that the port is connected to. */
#define takt_is_safe(port) takt_port_is_safe(&(port)->base)
/* Somebody is at the other end. */
#define takt_connected(port) takt_port_connected(&(port)->base)
/* Of the last sample that was read: its number as its writer counts them, from 1; 0 before the first. */
#define takt_sequence(port) takt_port_sequence(&(port)->base)
/* Of the last sample that was read: from the beginning of the run() that wrote it to the beginning of this
 * one, in nanoseconds; INT64_MAX before the first. */
#define takt_age_ns(port) takt_port_age_ns(&(port)->base)

/* A pointer to another type than the port's is refused by the compiler. */
#define TAKT_VALUE_OF(port, pointer) (1 ? (pointer) : (port)->value)

#define TAKT_PORT_OF_DIRECTION(Type, port, direction_)                                               \
  static struct {                                                                                    \
    takt_port base;                                                                                  \
    Type* value;                                                                                     \
  } port = {{#port, &Type##_type, direction_, 0}, 0};                                                \
  static void __attribute__((constructor)) takt_add_##port(void) { takt_add_port(&port.base); }      \
  static void __attribute__((destructor)) takt_remove_##port(void) { takt_remove_port(&port.base); } \
  struct takt_port_##port

#endif
