// Allocates and frees `bytes` (default 64) in every `every`-th run (default 1), which a real-time thread must
// not do.
#include <takt/module.h>

static std::size_t bytes = 64;
static long long every = 1;
static long long runs = 0;
static char* volatile memory = nullptr;  // volatile prevents the compiler from removing the allocation

extern "C" {
void initialize(irp::Property const& property) {
  bytes = property.get("bytes", std::size_t{64}, 1, 100000000);
  every = property.get("every", 1LL, 1, 1000000000);
}
void run(void) {
  if (++runs % every != 0) return;
  memory = new char[bytes];
  memory[0] = 1;
  delete[] memory;
}
}
