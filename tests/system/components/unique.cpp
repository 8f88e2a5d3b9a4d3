// As counter, with the count in an inline variable that was compiled to be one for the whole program
// (STB_GNU_UNIQUE): the one thing of which two copies of an object cannot each have their own.
#include "count_file.hpp"

#include <takt/module.h>

inline int shared_count = 0;

static std::string file;

extern "C" {
void initialize(irp::Property const& property) { file = property.get("file", ""); }
void run(void) { ++shared_count; }
void destruct(void) { write_count(file, shared_count); }
}
