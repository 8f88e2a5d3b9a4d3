/* Fills a C struct as a module in C does. */
#ifndef TAKT_TEST_C_VALUES_H
#define TAKT_TEST_C_VALUES_H

#include <everything_c.h>

#ifdef __cplusplus
extern "C" {
#endif
/* Sets the value that whole(1) of values.hpp returns. */
void fill_whole(everything_Whole* value);
#ifdef __cplusplus
}
#endif
#endif
