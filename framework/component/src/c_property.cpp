// The functions of <takt/property.h>, for thread modules and process modules in C. Part of libtakt_component
// and of libtakt_process.
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include <takt/property.h>
#include <takt/process.hpp>

namespace takt {
namespace {

/// A property whose value is also a variable in C. take_over() writes the variable.
template <class T, class Variable>
class CProperty final : public Property<T> {
 public:
  CProperty(const takt_property& property, T value, typename Property<T>::Options options)
      : Property<T>(property.name, std::move(value), std::move(options)),
        variable_(*static_cast<Variable*>(property.value)) {
    write_variable();  // the base class may have set the value, but it cannot write the variable
  }

  void take_over() noexcept override {
    Property<T>::take_over();
    write_variable();
  }

 private:
  void write_variable() noexcept {
    if constexpr (std::is_same_v<T, std::string>)
      variable_ = this->value().c_str();
    else
      variable_ = static_cast<Variable>(this->value());
  }

  Variable& variable_;
};

template <class T, class Variable>
PropertyBase* make(const takt_property& property, typename Property<T>::Options options) {
  const Variable value = *static_cast<Variable*>(property.value);
  options.unit = property.unit;
  options.text = property.text;
  return new CProperty<T, Variable>{property, T(value), std::move(options)};
}

PropertyBase* make(const takt_property& property) {
  constexpr auto kLeast = std::numeric_limits<std::int64_t>::min();
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  switch (property.type) {
    case TAKT_IS_FLAG:
      return make<bool, int>(property, {});
    case TAKT_IS_INTEGER: {
      Property<std::int64_t>::Options options;
      if (property.least != kLeast) options.min = property.least;
      if (property.most != kMost) options.max = property.most;
      return make<std::int64_t, std::int64_t>(property, std::move(options));
    }
    case TAKT_IS_NUMBER: {
      Property<double>::Options options;
      if (std::isfinite(property.min)) options.min = property.min;
      if (std::isfinite(property.max)) options.max = property.max;
      return make<double, double>(property, std::move(options));
    }
    case TAKT_IS_STRING:
      return make<std::string, const char*>(property, {});
  }
  return nullptr;
}

}  // namespace
}  // namespace takt

extern "C" {

void takt_add_property(takt_property* property) { property->inside = takt::make(*property); }

void takt_remove_property(takt_property* property) {
  delete static_cast<takt::PropertyBase*>(property->inside);
  property->inside = nullptr;
}
}
