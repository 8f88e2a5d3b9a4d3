// Replaces the functions of the C library that allocate memory or may wait. The replacements record the call
// and then call the original function. Calls that the original function makes are not recorded.
#include <dlfcn.h>
#include <malloc.h>
#include <pthread.h>
#include <semaphore.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <ctime>

#include "recorder.hpp"

namespace takt::check {
namespace {

/// Records a call of the C function `function` if a module makes the call. Pauses the recording until the
/// call ends.
class Call {
 public:
  Call(channel::ViolationKind kind, const char* function) noexcept {
    if (counted_) record({.kind = kind, .function = function});
  }

 private:
  bool counted_ = counts();
  Pause pause_;
};

}  // namespace
}  // namespace takt::check

using takt::channel::ViolationKind;
using takt::check::Call;

extern "C" {
void* __libc_malloc(std::size_t size) noexcept;
void* __libc_calloc(std::size_t n, std::size_t size) noexcept;
void* __libc_realloc(void* block, std::size_t size) noexcept;
void* __libc_memalign(std::size_t alignment, std::size_t size) noexcept;
void __libc_free(void* block) noexcept;
}

// The compiler's operator new and operator delete call malloc() and free(), so calls of these operators are
// recorded, too.
#pragma GCC visibility push(default)
extern "C" {

void* malloc(std::size_t size) noexcept {
  const Call call{ViolationKind::allocation, "malloc"};
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) noexcept {
  const Call call{ViolationKind::allocation, "calloc"};
  return __libc_calloc(n, size);
}
void* realloc(void* block, std::size_t size) noexcept {
  const Call call{ViolationKind::allocation, "realloc"};
  return __libc_realloc(block, size);
}
void* reallocarray(void* block, std::size_t n, std::size_t size) noexcept {
  const Call call{ViolationKind::allocation, "reallocarray"};
  std::size_t bytes = 0;
  if (__builtin_mul_overflow(n, size, &bytes)) {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_realloc(block, bytes);
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
  const Call call{ViolationKind::allocation, "memalign"};
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  const Call call{ViolationKind::allocation, "aligned_alloc"};
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  const Call call{ViolationKind::allocation, "posix_memalign"};
  if (alignment % sizeof(void*) != 0 || (alignment & (alignment - 1)) != 0 || alignment == 0) return EINVAL;
  void* found = __libc_memalign(alignment, size);
  if (found == nullptr) return ENOMEM;
  *block = found;
  return 0;
}
void free(void* block) noexcept {
  if (block == nullptr) return;
  const Call call{ViolationKind::allocation, "free"};
  __libc_free(block);
}

// Defines a function that records the call and then calls the C library's function. The C library also has an
// old version of the functions of condition variables, and dlsym() may find the old version first. So the
// macro requests version GLIBC_2.3.2.
#define TAKT_IN_FRONT_OF(name, parameters, ...)                                                           \
  int name parameters noexcept(noexcept(::name(__VA_ARGS__))) {                                           \
    static std::atomic<int(*) parameters> real{nullptr};                                                  \
    auto* function = real.load(std::memory_order_relaxed);                                                \
    const Call call{ViolationKind::lock, #name};                                                          \
    if (function == nullptr) {                                                                            \
      function = reinterpret_cast<int(*) parameters>(::dlvsym(RTLD_NEXT, #name, "GLIBC_2.3.2"));          \
      if (function == nullptr) function = reinterpret_cast<int(*) parameters>(::dlsym(RTLD_NEXT, #name)); \
      real.store(function, std::memory_order_relaxed);                                                    \
    }                                                                                                     \
    return function(__VA_ARGS__);                                                                         \
  }
TAKT_IN_FRONT_OF(pthread_mutex_lock, (pthread_mutex_t * mutex), mutex)
TAKT_IN_FRONT_OF(pthread_mutex_trylock, (pthread_mutex_t * mutex), mutex)
TAKT_IN_FRONT_OF(pthread_mutex_timedlock, (pthread_mutex_t * mutex, const timespec* until), mutex, until)
TAKT_IN_FRONT_OF(pthread_mutex_clocklock, (pthread_mutex_t * mutex, clockid_t clock, const timespec* until),
                 mutex, clock, until)
TAKT_IN_FRONT_OF(pthread_rwlock_rdlock, (pthread_rwlock_t * lock), lock)
TAKT_IN_FRONT_OF(pthread_rwlock_tryrdlock, (pthread_rwlock_t * lock), lock)
TAKT_IN_FRONT_OF(pthread_rwlock_wrlock, (pthread_rwlock_t * lock), lock)
TAKT_IN_FRONT_OF(pthread_rwlock_trywrlock, (pthread_rwlock_t * lock), lock)
TAKT_IN_FRONT_OF(pthread_spin_lock, (pthread_spinlock_t * lock), lock)
TAKT_IN_FRONT_OF(pthread_cond_wait, (pthread_cond_t * condition, pthread_mutex_t* mutex), condition, mutex)
TAKT_IN_FRONT_OF(pthread_cond_timedwait,
                 (pthread_cond_t * condition, pthread_mutex_t* mutex, const timespec* until), condition,
                 mutex, until)
TAKT_IN_FRONT_OF(pthread_cond_clockwait,
                 (pthread_cond_t * condition, pthread_mutex_t* mutex, clockid_t clock, const timespec* until),
                 condition, mutex, clock, until)
TAKT_IN_FRONT_OF(pthread_barrier_wait, (pthread_barrier_t * barrier), barrier)
TAKT_IN_FRONT_OF(pthread_join, (pthread_t thread, void** result), thread, result)
TAKT_IN_FRONT_OF(sem_wait, (sem_t * semaphore), semaphore)
TAKT_IN_FRONT_OF(sem_trywait, (sem_t * semaphore), semaphore)
TAKT_IN_FRONT_OF(sem_timedwait, (sem_t * semaphore, const timespec* until), semaphore, until)
TAKT_IN_FRONT_OF(sem_clockwait, (sem_t * semaphore, clockid_t clock, const timespec* until), semaphore, clock,
                 until)
#undef TAKT_IN_FRONT_OF
}
#pragma GCC visibility pop
