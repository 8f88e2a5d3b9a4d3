// A global variable and a function, both with names that the C library does not have. home() uses the C
// library, so that the object depends on it.
#include <cstdlib>

int counter = 0;
extern "C" int count_up() { return ++counter; }
extern "C" const char* home() { return std::getenv("HOME"); }
