// A periodic module that writes the value of its input in each run, also if the value is not new.
#include <takt/component.hpp>

#include "sample.hpp"

class PortLatest : public takt::Component {
  takt::InPort<samples::Count> in{*this, "in"};
  takt::OutPort<samples::Count> out{*this, "out"};

  void run(const takt::Cycle&) noexcept override {
    in.read();
    if (in.has_value()) out.write(in.value());
  }
};
TAKT_COMPONENT(PortLatest)
