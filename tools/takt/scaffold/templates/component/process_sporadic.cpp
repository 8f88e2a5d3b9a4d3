// A sporadic process module: a separate program that the scheduler releases to check for events.
#include <takt/process.hpp>

#include <@name@_types.hpp>

TAKT_TEXT("Multiplies each input by a gain.");

namespace {

takt::EventPort<@name@_types::Sample> in{"in", {.text = "The input."}};
takt::OutPort<@name@_types::Sample> out{"out", {.text = "The input times the gain."}};
takt::Property<double> gain{"gain", 2, {.min = -1000, .max = 1000, .text = "The factor."}};

}  // namespace

int main() {
  initSporadicExe();
  // Prepare here: allocate memory, open files. The first waitSporadic() reports that the module is ready.
  @name@_types::Sample result;
  while (true) {
    waitSporadic();
    while (in.read()) {
      result.value(gain * in.value().value());
      out.write(result);
    }
  }
}
