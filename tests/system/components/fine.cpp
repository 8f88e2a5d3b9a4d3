// A correct periodic module: counts its runs and writes the number to `file`, if given, at the end.
#include "count_file.hpp"

#include <takt/module.h>

static long long count = 0;
static std::string file;

extern "C" {
void initialize(irp::Property const& property) { file = property.get("file", ""); }
void start(void) {}
void run(void) { ++count; }
void error(int) {}
void recover(void) {}
void destruct(void) { write_count(file, count); }
}
