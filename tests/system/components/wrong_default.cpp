// A component with wrong properties: two defaults are outside their own ranges, one name is reserved, and two
// bounds are in the wrong order.
#include <takt/component.hpp>

class WrongDefault : public takt::Component {
  takt::Property<double> speed{*this, "speed", 20.0, {.min = 0.0, .max = 10.0}};
  takt::Property<int> parts{*this, "parts", 0, {.min = 1}};
  takt::Property<std::string> level{*this, "log-level", "info"};
  takt::Property<double> bounds{*this, "bounds", 1.0, {.min = 10.0, .max = 0.0}};
  takt::Property<double> fits{*this, "fits", 10.0, {.min = 0.0, .max = 10.0}};

  void run(const takt::Cycle&) noexcept override {}
};
TAKT_COMPONENT(WrongDefault)
