// A sporadic process module for `takt bench`, in the form of the paper's Figure 11: it is released in each
// row, and its condition holds every tenth time.
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
