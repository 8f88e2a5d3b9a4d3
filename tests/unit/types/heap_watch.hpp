// Counts the memory allocations of a thread, including the allocations of thrown exceptions.
#pragma once

#include <cstdint>

namespace takt::types_test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kHeapIsWatched = false;  ///< the sanitizer's own allocator does not count calls
#else
inline constexpr bool kHeapIsWatched = true;
#endif

/// begin_heap_watch() starts counting the allocations of the calling thread. end_heap_watch() returns their
/// number since then.
std::uint64_t begin_heap_watch();
std::uint64_t end_heap_watch();

/// Returns the number of allocations that this thread makes while f() runs.
template <class F>
std::uint64_t allocations_of(F f) {
  begin_heap_watch();
  f();
  return end_heap_watch();
}

}  // namespace takt::types_test
