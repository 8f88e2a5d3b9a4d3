// The header for authors of a component in C++. A component is one class:
//
//   class Ramp : public takt::Component {
//     takt::Property<double> slope{*this, "slope", 1.0, {.unit = "1/s", .min = 0.0}};
//     double value_ = 0;
//
//     void run(const takt::Cycle& cycle) noexcept override { value_ += slope * cycle.seconds(); }
//   };
//   TAKT_COMPONENT(Ramp, "A value that rises.")
//
// In CMake, takt_add_component(ramp ramp.cpp) builds it. A cell may have several modules of one component;
// each module is a separate object.
#pragma once

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include <takt/text.h>
#include <takt/component/event_port.hpp>
#include <takt/component/in_port.hpp>
#include <takt/component/out_port.hpp>
#include <takt/component/property.hpp>
#include <takt/component/saved.hpp>
#include <takt/component/service.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>

/// The interface of Takt for authors of components.
namespace takt {

/// One release of a module. By the paper's Eq. (1), `time` is P_n = T0 + n x period.
struct Cycle {
  std::uint64_t number = 0;  ///< n: release number on the module's grid, from 0; missed releases leave gaps
  Instant time{};            ///< when the release was due; equal for all modules of a row
  Nanoseconds period{};      ///< period of the module; for a sporadic module, of its executor's rows
  Instant start{};           ///< when run() was called; stamps of samples and ages refer to this time

  /// Returns the period in seconds. A real-time thread may call it.
  [[nodiscard]] double seconds() const noexcept { return std::chrono::duration<double>(period).count(); }
};

/// Why a module was taken out of its table. The numbers are the same as in <takt/module.h>.
enum class ErrorType : int {
  none = 0,      ///< no error
  failure = 1,   ///< run() or condition() threw or called fail()
  budget = 2,    ///< one run() took longer than `<budget>`
  start = 3,     ///< start() failed
  crash = 4,     ///< the host or the process module crashed or ended by itself
  hang = 5,      ///< run() or another hook did not return
  deadline = 6,  ///< a sporadic module missed its deadline, and its descriptor makes that an error
  stale = 7,     ///< an input was older than its connection's deadline, with stale="error"
  overrun = 8,   ///< a release was not served in time, and the descriptor makes that an error
};
/// "failure", "budget", ...
const char* to_text(ErrorType type) noexcept;

/// The base class of every component. A real-time thread calls run() and condition(). Another thread, which
/// is not real-time, calls all other hooks while the module is out of the tables. Two hooks never run at the
/// same time. An exception in a hook counts as a failure of the hook.
class Component {
 public:
  Component() = default;
  Component(const Component&) = delete;
  Component& operator=(const Component&) = delete;
  virtual ~Component() = default;

  /// Called when the properties have their values. The calling thread is not real-time, so initialize() may
  /// allocate, open files and connect. If it fails, the device does not start, and Takt reports the reason:
  /// `return takt::fail("the sensor does not answer", "switch it on");`
  virtual Result<void> initialize() { return {}; }
  /// Called between initialize() and start() if a former instance saved a value of another version or size.
  /// Put what is still valid into the Saved of this instance. If it fails, the value is not restored, the
  /// reason is reported, and the module starts all the same. A value of the same version and size is restored
  /// without this call. During a swap, restore() is called again, also after start(), until the new instance
  /// has the newest value; a failure then ends the swap. The calling thread is not real-time. The default
  /// implementation fails.
  virtual Result<void> restore(const SavedBefore& before);
  /// Called when every module of the device is initialised. It may fail. The calling thread is not real-time.
  virtual Result<void> start() { return {}; }
  /// Called every period, or when condition() is true. The calling thread is real-time, so run() must not
  /// lock, allocate, make a system call or log. It reports failures with fail().
  virtual void run(const Cycle& cycle) = 0;
  /// For a sporadic module: whether run() must be called. By default, it is true while an event port has an
  /// unread event. The calling thread is real-time, so the rules of run() apply.
  virtual bool condition();
  /// Called after an error took the module out of its table. The calling thread is not real-time.
  virtual void error(ErrorType /*type*/) {}
  /// Called after error(). Prepares the module to run again, or fails with the reason. The calling thread is
  /// not real-time.
  virtual Result<void> recover() { return {}; }
  /// Called last, before the object is destroyed. The calling thread is not real-time.
  virtual void destruct() {}

  /// The properties, in the order of declaration.
  [[nodiscard]] const std::vector<PropertyBase*>& properties() const noexcept { return properties_; }
  /// The ports, in the order of declaration.
  [[nodiscard]] const std::vector<PortBase*>& ports() const noexcept { return ports_; }
  /// The services that have a handler.
  [[nodiscard]] const std::vector<ServiceBase*>& services() const noexcept { return services_; }
  /// The Saved members. A component may have only one.
  [[nodiscard]] const std::vector<SavedBase*>& saved() const noexcept { return saved_; }

 protected:
  /// Returns the period of this module, or 0 if it has none. Every hook may call it; initialize() can check
  /// properties against the period. In run() and condition() of a sporadic module, it returns the period of
  /// the executor's rows. A real-time thread may call it.
  static Nanoseconds period() noexcept;
  /// Reports a failure from run() or condition(). The module is taken out of its table after the call, with
  /// this text as the reason (255 bytes are kept). fail() returns, so the hook must end itself. A real-time
  /// thread may call it.
  static void fail(const char* text) noexcept;

 private:
  friend class PropertyBase;
  friend class PortBase;
  friend class ServiceBase;
  friend class SavedBase;
  std::vector<PropertyBase*> properties_;  // in the order of declaration
  std::vector<PortBase*> ports_;
  std::vector<ServiceBase*> services_;
  std::vector<SavedBase*> saved_;
};

/// What the .so of a C++ component exports; TAKT_COMPONENT defines it.
struct ComponentFactory {
  static constexpr std::uint32_t kAbi = 5;  ///< version of this interface
  std::uint32_t abi;                        ///< kAbi when the component was compiled
  std::uint32_t component_size;             ///< sizeof(Component) when the component was compiled
  const char* name;                         ///< name of the class
  Component* (*create)();                   ///< creates an object of the class
  void (*destroy)(Component*);              ///< destroys an object
  bool own_condition;                       ///< whether the class overrides condition()
};

namespace detail {
template <class Type>
constexpr bool overrides_condition() {
  if constexpr (requires { &Type::condition; })
    return !std::is_same_v<decltype(&Type::condition), bool (Component::*)()>;
  else
    return true;  // it is overridden as a private member
}
}  // namespace detail

}  // namespace takt

/// Exports a component. Use it once in each component's source, outside any namespace. The optional second
/// argument describes the component in one sentence, for `takt describe`.
#define TAKT_COMPONENT(Type, ...)                                                   \
  __VA_OPT__(TAKT_TEXT(__VA_ARGS__);)                                               \
  extern "C" __attribute__((visibility("default"))) const ::takt::ComponentFactory* \
  takt_component_factory();                                                         \
  extern "C" const ::takt::ComponentFactory* takt_component_factory() {             \
    static constexpr ::takt::ComponentFactory factory{                              \
        ::takt::ComponentFactory::kAbi,                                             \
        sizeof(::takt::Component),                                                  \
        #Type,                                                                      \
        []() -> ::takt::Component* { return new Type; },                            \
        [](::takt::Component* component) { delete component; },                     \
        ::takt::detail::overrides_condition<Type>()};                               \
    return &factory;                                                                \
  }
