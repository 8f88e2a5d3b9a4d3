// A sporadic process module in C++ with properties. Prints their values at the start, and when they change.
#include <takt/process.hpp>

#include <cstdio>
#include <cstdlib>

TAKT_TEXT("A program with properties in C++.");

namespace {

takt::Property<double> gain{
    "gain", 1.5, {.unit = "1/s", .min = 0.0, .max = 100.0, .text = "How strong it is."}};
takt::Property<std::string> label{"label", "none"};

void print() { std::fprintf(stderr, "gain %g, label %s\n", gain.value(), label.value().c_str()); }

}  // namespace

int main() {
  print();  // the properties already have the values from the descriptor here
  initSporadicExe();
  for (double last = gain;; last = gain) {
    waitSporadic();
    if (gain != last) print();
  }
}
