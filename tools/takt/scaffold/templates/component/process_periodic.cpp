// A periodic process module: a separate program that the scheduler releases in every period.
#include <takt/process.hpp>

#include <@name@_types.hpp>

TAKT_TEXT("Multiplies the input by a gain.");

namespace {

takt::InPort<@name@_types::Sample> in{"in", {.text = "The input."}};
takt::OutPort<@name@_types::Sample> out{"out", {.text = "The input times the gain."}};
takt::Property<double> gain{"gain", 2, {.min = -1000, .max = 1000, .text = "The factor."}};

}  // namespace

int main() {
  initPeriodExe();
  // Prepare here: allocate memory, open files. The first waitPeriod() reports that the module is ready.
  @name@_types::Sample result;
  while (true) {
    waitPeriod();
    if (!in.read()) continue;  // no new sample since the last release
    result.value(gain * in.value().value());
    out.write(result);
  }
}
