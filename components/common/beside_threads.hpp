// Helps to test a process module that has its own threads besides its cyclic body.
#pragma once

#include <chrono>
#include <concepts>
#include <thread>

#include <takt/testing.hpp>

namespace common {

/// Steps the module until `done` returns true. Returns false if `done` returns false for 20 s. Makes one
/// release per millisecond of real time, because on virtual time the body would outrun a thread that runs in
/// real time.
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
