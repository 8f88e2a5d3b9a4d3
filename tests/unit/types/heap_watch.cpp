#include "heap_watch.hpp"

#include <cerrno>
#include <cstddef>

namespace {
thread_local bool watched [[gnu::tls_model("initial-exec")]] = false;
thread_local std::uint64_t allocations [[gnu::tls_model("initial-exec")]] = 0;

[[maybe_unused]] void count() noexcept { allocations += watched ? 1 : 0; }
}  // namespace

namespace takt::types_test {
std::uint64_t begin_heap_watch() {
  watched = true;
  return allocations = 0;
}
std::uint64_t end_heap_watch() {
  watched = false;
  return allocations;
}
}  // namespace takt::types_test

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// The following functions replace those of the C library. operator new calls the replacements, too.
extern "C" {
void* __libc_malloc(std::size_t size) noexcept;
void* __libc_calloc(std::size_t n, std::size_t size) noexcept;
void* __libc_realloc(void* block, std::size_t size) noexcept;
void* __libc_memalign(std::size_t alignment, std::size_t size) noexcept;

void* malloc(std::size_t size) noexcept {
  count();
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) noexcept {
  count();
  return __libc_calloc(n, size);
}
void* realloc(void* block, std::size_t size) noexcept {
  count();
  return __libc_realloc(block, size);
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
  count();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  count();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  count();
  *block = __libc_memalign(alignment, size);
  return *block == nullptr ? ENOMEM : 0;
}
}
#endif
