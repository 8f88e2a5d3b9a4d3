// A thread module in C++: a logic gate with up to four inputs.
#include <takt/component.hpp>

#include <array>
#include <string>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "gate.hpp"

class LogicGate : public takt::Component {
  using Input = takt::InPort<basic::Flag>;
  std::array<Input, 4> in{Input{*this, "in_1", {.text = "Input of the gate; ignored if not connected."}},
                          Input{*this, "in_2"}, Input{*this, "in_3"}, Input{*this, "in_4"}};
  takt::OutPort<basic::Flag> out{
      *this, "out", {.text = "Result; written every cycle once each connected input has received a sample."}};
  takt::Property<std::string> function{*this,
                                       "function",
                                       "and",
                                       {.text = "Logic function that combines the connected inputs.",
                                        .choices = {"and", "or", "xor", "nand", "nor", "not"}}};

  basic::Flag out_;

  [[nodiscard]] std::uint32_t used() const noexcept {
    std::uint32_t used = 0;
    for (std::size_t i = 0; i < in.size(); ++i) used |= in[i].connected() ? 1U << i : 0;
    return used;
  }

  takt::Result<void> initialize() override {
    if (used() == 0) return takt::fail("no input is connected", "connect a flag to one of in_1 to in_4");
    return {};
  }

  void run(const takt::Cycle&) noexcept override {
    std::uint32_t come = 0;
    std::uint32_t given = 0;
    for (std::size_t i = 0; i < in.size(); ++i) {
      common::read_newest(in[i]);
      if (in[i].has_value()) come |= 1U << i;
      if (in[i].value().value()) given |= 1U << i;
    }
    if ((used() & ~come) != 0 || used() == 0) return;
    out_.value(logic_gate::output(*logic_gate::function_of(function.value()), used(), given));
    out.write(out_);
  }
};
TAKT_COMPONENT(LogicGate, "Logic gate for flags: and, or, xor, nand, nor, not.")
