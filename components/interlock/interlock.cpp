// A thread module in C++: permits an action while all conditions are true, and reports which condition failed
// first.
#include <takt/component.hpp>

#include <array>
#include <cmath>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "permissives.hpp"

class Interlock : public takt::Component {
  using Input = takt::InPort<basic::Flag>;
  std::array<Input, 8> in{Input{*this, "in_1", {.text = "A permissive; ignored if not connected."}},
                          Input{*this, "in_2"},
                          Input{*this, "in_3"},
                          Input{*this, "in_4"},
                          Input{*this, "in_5"},
                          Input{*this, "in_6"},
                          Input{*this, "in_7"},
                          Input{*this, "in_8"}};
  Input reset{*this, "reset", {.text = "A rising edge clears first_out if all permissives are true."}};
  takt::OutPort<basic::Flag> permitted{
      *this, "permitted", {.text = "True if all connected permissives are true.", .safe = basic::Flag{}}};
  takt::OutPort<basic::Count> first_out{
      *this,
      "first_out",
      {.text = "Number of the permissive that became false first, 1 to 8; 0: none since the last reset."}};
  takt::Property<bool> latching{
      *this, "latching", false, {.text = "True: permission returns only after a reset."}};
  takt::Property<double> timeout{
      *this,
      "timeout",
      0,
      {.unit = "s",
       .min = 0,
       .max = 1e6,
       .text = "An input older than this counts as false; 0: inputs never expire."}};

  interlock::Permissives permissives_;
  common::RisingEdge reset_;
  basic::Flag flag_;
  basic::Count count_;

  takt::Result<void> initialize() override {
    for (const Input& input : in) {
      if (input.connected()) return {};
    }
    return takt::fail("no permissive is connected, so the module can never permit anything",
                      "connect a flag to one of in_1 to in_8");
  }

  void run(const takt::Cycle&) noexcept override {
    std::uint32_t used = 0;
    std::uint32_t given = 0;
    for (std::size_t i = 0; i < in.size(); ++i) {
      common::read_newest(in[i]);
      if (in[i].connected()) used |= 1U << i;
      if (in[i].value().value() && fresh(in[i])) given |= 1U << i;
    }
    const bool acknowledge = common::count_rising(reset, reset_) > 0;
    permissives_.step(used, given, latching, acknowledge);
    tell(permissives_.permitted());
  }

  [[nodiscard]] bool fresh(const Input& input) const noexcept {
    return input.has_value() && (timeout <= 0 || input.age().count() <= std::llround(timeout * 1e9));
  }
  void tell(bool is) noexcept {
    flag_.value(is);
    permitted.write(flag_);
    count_.value(permissives_.first_out());
    first_out.write(count_);
  }

  void error(takt::ErrorType) override { tell(false); }
  void destruct() override { tell(false); }
};
TAKT_COMPONENT(Interlock,
               "Permits an action while all connected inputs are true; reports which input failed first.")
