// Does what the property `sin` (none) names in every run(). With `in_condition`, it also does this in every
// condition(), which always returns true.
#include <takt/component.hpp>

#include "sins.h"

class Sins : public takt::Component {
  takt::Property<std::string> sin{*this, "sin", "none"};
  takt::Property<bool> in_condition{*this, "in_condition", false};
  std::string name_;
  int* volatile number_ = nullptr;  // volatile prevents the compiler from removing the allocation

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
    if (name_ == "new") {
      number_ = new int{1};
      delete number_;
      SIN_IS_DONE;
    }
  }
};
TAKT_COMPONENT(Sins)
