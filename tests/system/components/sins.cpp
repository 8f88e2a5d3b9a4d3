// Does `sin` (none) in every run(), or, where `in_condition`, in every condition(), which always holds.
#include <stdexcept>

#include <takt/component.hpp>

#include "sins.h"

class Sins : public takt::Component {
  takt::Property<std::string> sin{*this, "sin", "none"};
  takt::Property<bool> in_condition{*this, "in_condition", false};
  std::string name_;

  takt::Result<void> initialize() override {
    sins_prepare();
    const std::string& name = sin;
    name_ = name;
    return {};
  }
  bool condition() override {
    if (in_condition) sin_by_name(name_.c_str());
    return true;
  }
  void run(const takt::Cycle&) noexcept override {
    if (!in_condition) sin_by_name(name_.c_str());
    if (name_ == "new") delete new int{1};
  }
};
TAKT_COMPONENT(Sins)
