// A component that finishes in its 50th run.
#include <takt/component.hpp>

class Finishes : public takt::Component {
  int runs_ = 0;

  void run(const takt::Cycle&) noexcept override {
    if (++runs_ == 50) finish();
  }
};
TAKT_COMPONENT(Finishes)
