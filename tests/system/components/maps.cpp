// In every `every`-th run (default 1), gets memory from the kernel, writes to one page after the other for
// `ns` nanoseconds, and returns the memory to the kernel.
#include <sys/mman.h>
#include <unistd.h>

#include <chrono>

#include <takt/module.h>

static std::chrono::nanoseconds length{};
static long long every = 1;
static long long runs = 0;

extern "C" {
void initialize(irp::Property const& property) {
  length = std::chrono::nanoseconds{property.get("ns", 1000000LL, 0, 1000000000)};
  every = property.get("every", 1LL, 1, 1000000000);
}
void run(void) {
  if (++runs % every != 0) return;
  const auto end = std::chrono::steady_clock::now() + length;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  constexpr std::size_t kAtOnce =
      64;  // pages; if all memory of the process is locked, the kernel provides them in one call
  while (std::chrono::steady_clock::now() < end) {
    void* const memory = mmap(nullptr, kAtOnce * page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return;
    mprotect(memory, kAtOnce * page, PROT_READ | PROT_WRITE);
    for (std::size_t at = 0; at < kAtOnce; ++at) static_cast<volatile char*>(memory)[at * page] = 1;
    munmap(memory, kAtOnce * page);
  }
}
}
