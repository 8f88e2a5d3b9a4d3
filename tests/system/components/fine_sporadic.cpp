// A good sporadic module: its condition holds at every `every`-th check. Writes the number of runs to `file`
// at the end.
#include "count_file.hpp"

#include <takt/module.h>

static long long every = 10;
static long long checks = 0;
static long long count = 0;
static std::string file;

extern "C" {
void initialize(irp::Property const& property) {
  every = property.get("every", 10LL, 1, 1000000000);
  file = property.get("file", "");
}
int condition(void) { return ++checks % every == 0 ? TRUE : FALSE; }
void run(void) { ++count; }
void destruct(void) { write_count(file, count); }
}
