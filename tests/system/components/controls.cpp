// A component all of whose texts contain control characters: descriptions, default values, log lines, output,
// reasons of rejected requests, and exceptions. If `fails` is set, one run() in 50 fails.
#include <takt/component.hpp>

#include <cstdio>
#include <stdexcept>

#include "controls.h"
#include "sample.hpp"

TAKT_TEXT("text " CONTROLS);

class Controls : public takt::Component {
  takt::Service<samples::Count, samples::Count> rejects{
      *this, "rejects", [](const samples::Count& request) -> takt::Result<samples::Count> {
        if (request.number() == 1) throw std::runtime_error("exception " CONTROLS);
        return takt::fail("reason " CONTROLS, "cure " CONTROLS);
      }};
  takt::OutPort<samples::Count> out{*this, "out", {.text = "port " CONTROLS}};
  takt::Property<std::string> label{*this, "label", "default " CONTROLS, {.text = "property " CONTROLS}};
  takt::Property<std::string> direction{*this, "direction", "a\u202eb\u009bc"};
  takt::Property<double> number{*this, "number", 1.0, {.unit = "unit " CONTROLS, .min = 0.0, .max = 2.0}};
  takt::Property<bool> fails{*this, "fails", false};
  samples::Count count_;

  takt::Result<void> initialize() override {
    log().error("log {}", CONTROLS);
    std::printf("output %s\n", CONTROLS);
    std::fflush(stdout);
    std::fprintf(stderr, "error \xff %s\n", CONTROLS);
    return {};
  }
  void run(const takt::Cycle& cycle) noexcept override {
    if (cycle.number % 100 == 5) log().warning(CONTROLS);
    if (fails && cycle.number % 50 == 5) fail("failure " CONTROLS);
    count_.number(cycle.number);
    out.write(count_);
  }
  takt::Result<void> recover() override { return takt::fail("recovery " CONTROLS, "cure " CONTROLS); }
  void destruct() override { throw std::runtime_error("exception " CONTROLS); }
};
TAKT_COMPONENT(Controls)
