// A component or, with PROGRAM, a program whose property has an invalid name.
#ifdef PROGRAM
#include <takt/process.hpp>

takt::Property<double> speed{"belt speed", 1.0};

int main() {
  initPeriodExe();
  for (;;) waitPeriod();
}
#else
#include <takt/component.hpp>

class WrongName : public takt::Component {
  takt::Property<double> speed{*this, "belt speed", 1.0};

  void run(const takt::Cycle&) noexcept override {}
};
TAKT_COMPONENT(WrongName)
#endif
