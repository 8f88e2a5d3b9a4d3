// A component that creates a property only in initialize(), when it is too late.
#include <takt/component.hpp>

#include <optional>

class Late : public takt::Component {
  std::optional<takt::Property<double>> speed_;

  takt::Result<void> initialize() override {
    speed_.emplace(*this, "speed", 1.0);
    return {};
  }
  void run(const takt::Cycle&) noexcept override {}
};
TAKT_COMPONENT(Late)
