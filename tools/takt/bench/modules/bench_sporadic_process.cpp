// A sporadic process module for `takt bench`, written like the paper's Figure 11. Each row releases the
// module, and its condition is true in every tenth row.
#include <takt/process.h>

#include "filter_step.hpp"

namespace {

bool condition() {
  static int rows = 0;
  waitSporadic();
  return ++rows % 10 == 0;
}

}  // namespace

int main() {
  takt::bench::Work work;
  initSporadicExe();
  while (true) {
    if (!condition()) continue;
    work.step();
  }
}
