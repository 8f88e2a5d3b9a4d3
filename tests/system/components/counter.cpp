// Legacy code that counts its runs in an exported global variable. Two modules made from this file must not
// share the variable. Each module writes its count to `file` at the end.
#include "count_file.hpp"

#include <takt/module.h>

extern "C" {
int counter = 0;

static std::string file;

void initialize(irp::Property const& property) { file = property.get("file", ""); }
void run(void) { ++counter; }
void destruct(void) { write_count(file, counter); }
}
