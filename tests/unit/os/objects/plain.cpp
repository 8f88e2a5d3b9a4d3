// An object with a global variable and a function whose names do not exist in the C library. home() calls the
// C library, so that the object depends on it.
#include <cstdlib>

int counter = 0;
extern "C" int count_up() { return ++counter; }
extern "C" const char* home() { return std::getenv("HOME"); }
