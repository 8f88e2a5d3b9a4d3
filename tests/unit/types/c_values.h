/* A value as a module in C makes it. */
#ifndef TAKT_TEST_C_VALUES_H
#define TAKT_TEST_C_VALUES_H

#include <everything_c.h>

#ifdef __cplusplus
extern "C" {
#endif
/* The same as whole(1) of values.hpp. */
void fill_whole(everything_Whole* value);
#ifdef __cplusplus
}
#endif
#endif
