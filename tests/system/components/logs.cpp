// Logs one line in initialize(). In every `every`-th release, it logs `lines` lines of level info, then one
// line of level debug and, if `fails` is set, one of level error.
#include <takt/component.hpp>

class Logs : public takt::Component {
  takt::Property<std::int64_t> every{*this, "every", 100, {.min = 1}};
  takt::Property<std::int64_t> lines{*this, "lines", 1};
  takt::Property<bool> fails{*this, "fails", false};

  takt::Result<void> initialize() override {
    log().info("logs every {} cycles", every);
    return {};
  }
  void run(const takt::Cycle& cycle) noexcept override {
    if (cycle.number % static_cast<std::uint64_t>(every.value()) != 0) return;
    for (std::int64_t i = 0; i < lines; ++i)
      log().info("line {} of {} in a period of {:.3f} s, {}", i + 1, lines, cycle.seconds(), "as expected");
    log().debug("cycle {}", cycle.number);
    if (fails) log().error("failed in release {}", cycle.number);
  }
};
TAKT_COMPONENT(Logs)
