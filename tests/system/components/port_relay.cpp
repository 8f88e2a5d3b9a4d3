// A periodic process module in C++ that forwards the samples that it reads.
#include <takt/process.hpp>

#include "sample.hpp"

namespace {
takt::InPort<samples::Count> in{"in", {.text = "What \"it\" is to pass on."}};
takt::OutPort<samples::Count> out{"out"};
}  // namespace

int main() {
  initPeriodExe();
  while (true) {
    waitPeriod();
    while (in.read()) out.write(in.value());
  }
}
