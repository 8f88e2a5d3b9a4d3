// A sporadic process module in C++ that forwards each event and reports wrong samples.
#include <takt/process.hpp>

#include <cstdio>

#include "sample.hpp"

int main() {
  takt::EventPort<samples::Count> event{"event"};
  takt::OutPort<samples::Count> echo{"echo"};
  Seen seen;
  initSporadicExe();
  while (true) {
    waitSporadic();
    while (event.read()) {
      const auto wrong = seen.wrong;
      seen.take(event.value(), event.age().count());
      if (seen.wrong != wrong)
        std::printf("wrong: %llu\n", static_cast<unsigned long long>(event.value().number()));
      echo.write(event.value());
    }
  }
}
