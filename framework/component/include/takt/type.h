/** @file
 * takt_type: describes, encodes and decodes the samples of a port in C. takt_add_idl generates a takt_type
 * for every struct of an IDL file:
 *
 *     takt_add_idl(types motion.idl)          in CMake
 *     #include <motion_c.h>                   the struct motion_JointState and its motion_JointState_type
 *
 * In C, a string<N> is a char[N + 1] that contains a zero byte. A sequence<T, N> is a
 * struct { uint32_t length; T items[N]; }. */
#ifndef TAKT_TYPE_H
#define TAKT_TYPE_H

#include <stdint.h>

/** The description of a type, and its conversion to and from CDR. */
typedef struct takt_type {
  const char* name;        /**< "motion::JointState", the name on DDS */
  const char* description; /**< JSON; types with equal descriptions are the same type */
  uint32_t max_size;       /**< maximum size of a CDR sample in bytes, with encapsulation; a multiple of 4 */
  uint32_t value_size;     /**< bytes of the struct in memory */
  /** Writes the value as CDR and returns the number of bytes written. Returns 0 if `size` is too small for
   * the sample, or if a field exceeds its bound. A real-time thread may call it. */
  uint32_t (*encode)(const void* value, unsigned char* to, uint32_t size);
  /** Reads a sample and returns 1. Returns 0 if the bytes are not a valid sample; the content of `value` is
   * then unspecified. A real-time thread may call it. */
  int (*decode)(const unsigned char* from, uint32_t size, void* value);
} takt_type;

#endif
