// For tests of programs that have threads of their own.
#pragma once

#include <chrono>
#include <concepts>
#include <thread>

#include <takt/testing.hpp>

namespace common {

/// Steps until it is true: a release each millisecond, for a body on virtual time would outrun a thread,
/// whose clock is the real one. False after 20 s.
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
