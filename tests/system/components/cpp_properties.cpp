// A correct component in C++ with a property of each type, with and without bounds.
#include <takt/component.hpp>

class CppProperties : public takt::Component {
  takt::Property<bool> enabled{*this, "enabled", true, {.text = "Whether it counts."}};
  takt::Property<std::int32_t> count{
      *this, "count", 3, {.unit = "parts", .min = 1, .max = 10, .text = "At a time."}};
  takt::Property<std::int64_t> offset{*this, "offset", 0};
  takt::Property<double> gain{
      *this, "gain", 1.5, {.unit = "1/s", .min = 0.0, .max = 100.0, .text = "Of the loop."}};
  takt::Property<float> ratio{*this, "ratio", 0.5f, {.min = 0.0f}};
  takt::Property<std::string> label{*this, "label", "none", {.text = "For the log."}};
  double value_ = 0;

  void run(const takt::Cycle& cycle) noexcept override {
    if (enabled) value_ += gain * ratio * count * cycle.seconds() + static_cast<double>(offset);
  }
};
TAKT_COMPONENT(CppProperties)
TAKT_COMPONENT_VERSION("1.2.0");
