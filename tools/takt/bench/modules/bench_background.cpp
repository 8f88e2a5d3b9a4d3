// A non-real-time process module for `takt bench`. It uses a tenth of one CPU's time.
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
