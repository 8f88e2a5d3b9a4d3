// Replaces the allocation and lock functions of the C library. Counts the calls that watched threads make.
#include <pthread.h>

#include <cerrno>
#include <cstddef>

#include "real_time_path.hpp"

namespace takt::host {

std::atomic<std::uint64_t> allocations{0};
std::atomic<std::uint64_t> frees{0};
std::atomic<std::uint64_t> locks{0};
std::atomic<std::uint64_t> waits{0};

namespace {
thread_local bool watched [[gnu::tls_model("initial-exec")]] = false;

[[maybe_unused]] void count(std::atomic<std::uint64_t>& counter) noexcept {
  if (watched) counter.fetch_add(1, std::memory_order_relaxed);
}
}  // namespace

bool watch() { return !std::exchange(watched, true); }

}  // namespace takt::host

#if !TAKT_SANITIZED
#include <dlfcn.h>

using namespace takt::host;

// The following functions replace those of the C library. operator new and operator delete call the
// replacements, too.
extern "C" {
void* __libc_malloc(std::size_t size) noexcept;
void* __libc_calloc(std::size_t n, std::size_t size) noexcept;
void* __libc_realloc(void* block, std::size_t size) noexcept;
void* __libc_memalign(std::size_t alignment, std::size_t size) noexcept;
void __libc_free(void* block) noexcept;

void* malloc(std::size_t size) noexcept {
  count(allocations);
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) noexcept {
  count(allocations);
  return __libc_calloc(n, size);
}
void* realloc(void* block, std::size_t size) noexcept {
  count(allocations);
  return __libc_realloc(block, size);
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
  count(allocations);
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  count(allocations);
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  count(allocations);
  *block = __libc_memalign(alignment, size);
  return *block == nullptr ? ENOMEM : 0;
}
void free(void* block) noexcept {
  count(frees);
  __libc_free(block);
}

#define TAKT_FORWARD(counter, version, name, parameters, ...)                                             \
  int name parameters noexcept(noexcept(::name(__VA_ARGS__))) {                                           \
    static std::atomic<int(*) parameters> real{nullptr};                                                  \
    auto* function = real.load(std::memory_order_relaxed);                                                \
    if (function == nullptr) {                                                                            \
      function = reinterpret_cast<int(*) parameters>(::dlvsym(RTLD_NEXT, #name, version));                \
      if (function == nullptr) function = reinterpret_cast<int(*) parameters>(::dlsym(RTLD_NEXT, #name)); \
      real.store(function, std::memory_order_relaxed);                                                    \
    }                                                                                                     \
    count(counter);                                                                                       \
    return function(__VA_ARGS__);                                                                         \
  }
TAKT_FORWARD(locks, "GLIBC_2.2.5", pthread_mutex_lock, (pthread_mutex_t * mutex), mutex)
TAKT_FORWARD(locks, "GLIBC_2.2.5", pthread_mutex_trylock, (pthread_mutex_t * mutex), mutex)
TAKT_FORWARD(locks, "GLIBC_2.2.5", pthread_mutex_unlock, (pthread_mutex_t * mutex), mutex)
TAKT_FORWARD(locks, "GLIBC_2.2.5", pthread_rwlock_rdlock, (pthread_rwlock_t * lock), lock)
TAKT_FORWARD(locks, "GLIBC_2.2.5", pthread_rwlock_wrlock, (pthread_rwlock_t * lock), lock)
TAKT_FORWARD(waits, "GLIBC_2.3.2", pthread_cond_wait, (pthread_cond_t * condition, pthread_mutex_t* mutex),
             condition, mutex)
TAKT_FORWARD(waits, "GLIBC_2.3.2", pthread_cond_timedwait,
             (pthread_cond_t * condition, pthread_mutex_t* mutex, const timespec* until), condition, mutex,
             until)
TAKT_FORWARD(waits, "GLIBC_2.30", pthread_cond_clockwait,
             (pthread_cond_t * condition, pthread_mutex_t* mutex, clockid_t clock, const timespec* until),
             condition, mutex, clock, until)
#undef TAKT_FORWARD
}
#endif
