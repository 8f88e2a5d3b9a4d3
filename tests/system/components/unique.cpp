// A module that counts its runs in an inline variable, which the linker makes unique in the process
// (STB_GNU_UNIQUE). Two copies of the object therefore share this variable.
#include "count_file.hpp"

#include <takt/module.h>

inline int shared_count = 0;

static std::string file;

extern "C" {
void initialize(irp::Property const& property) { file = property.get("file", ""); }
void run(void) { ++shared_count; }
void destruct(void) { write_count(file, shared_count); }
}
