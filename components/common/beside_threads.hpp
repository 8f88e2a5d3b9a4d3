// For tests of programs that have threads of their own.
#pragma once

#include <chrono>
#include <concepts>
#include <thread>

#include <takt/testing.hpp>

namespace common {

/// Steps the module until `done` is true; false after 20 s. It makes one release per real millisecond,
/// because a body on virtual time would outrun a thread that runs on real time.
template <std::predicate Done>
bool comes_in_time(takt::testing::Module& module, Done&& done) {
  using namespace std::chrono_literals;
  for (const auto limit = std::chrono::steady_clock::now() + 20s; std::chrono::steady_clock::now() < limit;) {
    if (module.step_until(done, 1)) return true;
    std::this_thread::sleep_for(1ms);
  }
  return false;
}

}  // namespace common
