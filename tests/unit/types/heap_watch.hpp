// What a thread allocates while it is watched; an exception allocates too.
#pragma once

#include <cstdint>

namespace takt::types_test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kHeapIsWatched = false;  ///< the sanitizer has an allocator of its own
#else
inline constexpr bool kHeapIsWatched = true;
#endif

/// Allocations of this thread while f() runs.
std::uint64_t begin_heap_watch();
std::uint64_t end_heap_watch();

template <class F>
std::uint64_t allocations_of(F f) {
  begin_heap_watch();
  f();
  return end_heap_watch();
}

}  // namespace takt::types_test
