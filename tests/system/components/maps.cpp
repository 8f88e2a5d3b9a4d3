// In every `every`-th run (default 1), gets `pages` pages of memory from the kernel, writes to each page, and
// returns the pages to the kernel.
#include <sys/mman.h>
#include <unistd.h>

#include <takt/module.h>

static long long pages = 1;
static long long every = 1;
static long long runs = 0;

extern "C" {
void initialize(irp::Property const& property) {
  pages = property.get("pages", 1LL, 1, 1000000);
  every = property.get("every", 1LL, 1, 1000000000);
}
void run(void) {
  if (++runs % every != 0) return;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t size = page * static_cast<std::size_t>(pages);
  void* const memory = mmap(nullptr, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return;
  madvise(memory, size, MADV_NOHUGEPAGE);
  mprotect(memory, size, PROT_READ | PROT_WRITE);
  for (std::size_t at = 0; at < size; at += page) static_cast<volatile char*>(memory)[at] = 1;
  munmap(memory, size);
}
}
