// A non-real-time program for `takt bench`, which uses a tenth of a CPU's time.
#include <chrono>
#include <thread>

#include "filter_step.hpp"

int main() {
  using Clock = std::chrono::steady_clock;
  using namespace std::chrono_literals;
  takt::bench::Work work;
  while (true) {
    for (const auto end = Clock::now() + 1ms; Clock::now() < end;) work.step();
    std::this_thread::sleep_for(9ms);
  }
}
