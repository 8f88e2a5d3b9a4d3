// Owner: the type of the first constructor argument of a component's ports and properties, *this. InProgram:
// a concept that holds only in the sources of process modules, whose ports and properties have no owner. Both
// make the compiler reject wrong code. Otherwise a port or property could belong to no component, and Takt
// would not know of it.
#pragma once

#include <string>
#include <type_traits>

namespace takt {

class Component;

namespace detail {

/// True for a class that is not derived from Component.
template <class T>
concept NoComponent = std::is_class_v<T> && !std::is_base_of_v<Component, T>;

/// The component that owns a port or property.
class Owner {
 public:
  Owner(Component& component) noexcept : component_(&component) {}  // NOLINT(google-explicit-constructor)
  /// Reports the mistake that the class of *this is not a component.
  template <NoComponent Other>
  Owner(Other& other) noexcept {  // NOLINT(google-explicit-constructor)
    static_assert(sizeof(other) == 0,
                  "*this is not a component: derive the class from takt::Component or, in a program, omit "
                  "*this, as in takt::InPort<T> in{\"in\"}");
  }
  [[nodiscard]] Component* component() const noexcept { return component_; }

 private:
  Component* component_ = nullptr;
};

/// Reports that the current hook failed, and returns true, if the component of this thread is already
/// constructed: Takt learns of the ports, the properties and the saved state of a component from its
/// constructor, so it would ignore this one. `what` is for example "port 'speed'". In a process module, which
/// has no component, the function only returns false.
bool report_late(const std::string& what);

/// Only <takt/process.hpp> defines this type, so it is complete only in the sources of process modules.
template <class T>
struct ProcessHeader;

/// True if this source file may declare ports, properties and saved state without a component. The parameter
/// `T` only delays the check until the source uses the constructor.
template <class T>
concept InProgram = requires {
  sizeof(ProcessHeader<T>);
};

}  // namespace detail
}  // namespace takt
