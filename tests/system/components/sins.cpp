// Violates a real-time rule in every run(); the property `sin` (default none) names the violation. With
// `in_condition`, the violation is in every condition() instead, except for `new` and `text`, which stay in
// run().
#include <takt/component.hpp>

#include "sins.h"

class Sins : public takt::Component {
  takt::Property<std::string> sin{*this, "sin", "none"};
  takt::Property<bool> in_condition{*this, "in_condition", false};
  std::string name_;
  std::string text_;
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
    }
    if (name_ == "text") text_ = name_ + " is too long for the space in the object";
  }
};
TAKT_COMPONENT(Sins)
