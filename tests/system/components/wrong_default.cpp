// A component with properties whose defaults are outside their own ranges.
#include <takt/component.hpp>

class WrongDefault : public takt::Component {
  takt::Property<double> speed{*this, "speed", 20.0, {.min = 0.0, .max = 10.0}};
  takt::Property<int> parts{*this, "parts", 0, {.min = 1}};
  takt::Property<double> fits{*this, "fits", 10.0, {.min = 0.0, .max = 10.0}};

  void run(const takt::Cycle&) noexcept override {}
};
TAKT_COMPONENT(WrongDefault)
