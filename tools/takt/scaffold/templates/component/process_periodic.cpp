// A periodic process module: a program of its own that the scheduler releases every period.
#include <takt/process.hpp>

#include <@name@_types.hpp>

TAKT_TEXT("Multiplies what comes in.");

namespace {

takt::InPort<@name@_types::Sample> in{"in", {.text = "What is multiplied."}};
takt::OutPort<@name@_types::Sample> out{"out", {.text = "The same, times the gain."}};
takt::Property<double> gain{"gain", 2, {.min = -1000, .max = 1000, .text = "What it is multiplied with."}};

}  // namespace

int main() {
  initPeriodExe();
  // Here one may allocate, open and take time: the module is ready when it waits for the first time.
  @name@_types::Sample result;
  while (true) {
    waitPeriod();
    if (!in.read()) continue;  // nothing has come since the last release
    result.value(gain * in.value().value());
    out.write(result);
  }
}
