/* What a port of a module in C must know of its type. takt_add_idl generates it for every struct of an IDL
 * file:
 *
 *   takt_add_idl(types motion.idl)          in CMake
 *   #include <motion_c.h>                   the struct motion_JointState and its motion_JointState_type
 *
 * A string<N> is char[N + 1] with a zero in it; a sequence<T, N> is struct { uint32_t length; T items[N]; }.
 */
#ifndef TAKT_TYPE_H
#define TAKT_TYPE_H

#include <stdint.h>

typedef struct takt_type {
  const char* name;        /* "motion::JointState", its name on DDS */
  const char* description; /* JSON; two types are one when this is equal */
  uint32_t max_size;       /* most bytes of a sample as CDR: with encapsulation, in whole words of 4 bytes */
  uint32_t value_size;     /* of the struct in memory */
  /* Bytes written; 0 when `size` is less than the sample needs or a field is beyond its bound. Real-time. */
  uint32_t (*encode)(const void* value, unsigned char* to, uint32_t size);
  /* 0 when the bytes are no sample, and what the value then holds is not said. Real-time. */
  int (*decode)(const unsigned char* from, uint32_t size, void* value);
} takt_type;

#endif
