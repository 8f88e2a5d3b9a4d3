// A component whose constructor fails.
#include <takt/component.hpp>

#include <stdexcept>

class Throws : public takt::Component {
 public:
  Throws() { throw std::runtime_error("the sensor does not answer"); }

 private:
  void run(const takt::Cycle&) noexcept override {}
};
TAKT_COMPONENT(Throws)
