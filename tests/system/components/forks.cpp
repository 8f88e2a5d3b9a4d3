// Calls fork() in its `after`-th run (default 100), so that both processes return from run(). Each later run
// appends the id of its process to the file `file`.
#include <takt/module.h>

#include <fstream>
#include <string>

#include <unistd.h>

static long long after = 100;
static long long runs = 0;
static std::string file;

extern "C" {
void initialize(irp::Property const& property) {
  after = property.get("after", 100LL, 1, 1000000000);
  file = property.get("file", "");
}
void run(void) {
  if (++runs > after) std::ofstream{file, std::ios::app} << getpid() << '\n';
  if (runs == after) static_cast<void>(fork());
}
}
