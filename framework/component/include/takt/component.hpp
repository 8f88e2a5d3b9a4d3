// What the author of a component in C++ includes. A component is one class:
//
//   class Ramp : public takt::Component {
//     takt::Property<double> slope{*this, "slope", 1.0, {.unit = "1/s", .min = 0.0, .text = "How fast it
//     rises."}}; double value_ = 0;
//
//     void run(const takt::Cycle& cycle) noexcept override { value_ += slope * cycle.seconds(); }
//   };
//   TAKT_COMPONENT(Ramp, "A value that rises.")
//
// built with takt_add_component(ramp ramp.cpp). Several modules may be made of one component: each is an
// object of its own.
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

namespace takt {

/// One release of a module, by the paper's Eq. (1): `time` is P_n = T0 + n x period.
struct Cycle {
  std::uint64_t number = 0;  ///< n: the place in the module's grid, from 0; a missed release leaves a gap
  Instant time{};            ///< when it was due, the same for all modules of a row
  Nanoseconds period{};      ///< of the module; for a sporadic one, of its executor's rows
  Instant start{};           ///< when run() was called: what ports stamp samples with and reckon ages from

  [[nodiscard]] double seconds() const noexcept { return std::chrono::duration<double>(period).count(); }
};

/// Why a module was taken out of its table. The numbers are those of <takt/module.h>.
enum class ErrorType : int {
  none = 0,
  failure = 1,   ///< run() or condition() threw or called fail()
  budget = 2,    ///< one run() took longer than <budget>
  start = 3,     ///< start() failed
  crash = 4,     ///< the host or the process module crashed or ended by itself
  hang = 5,      ///< run() or a hook did not come back
  deadline = 6,  ///< a sporadic module was not done by its deadline, and its descriptor calls that an error
  stale = 7,     ///< an input is older than its connection's deadline, with stale="error"
  overrun = 8,   ///< a release was not served in time, and the descriptor calls that an error
};
/// "failure", "budget", ...
const char* to_text(ErrorType type) noexcept;

/// The base of every component. run() and condition() are called by a real-time thread, all other hooks by a
/// thread that is not real-time, with the module out of the tables; never two at once.
class Component {
 public:
  Component() = default;
  Component(const Component&) = delete;
  Component& operator=(const Component&) = delete;
  virtual ~Component() = default;

  /// Properties are set. May allocate, open, connect. A failure says why and refuses the device's start:
  /// `return takt::fail("the sensor does not answer", "switch it on");`
  virtual Result<void> initialize() { return {}; }
  /// A former instance, of another version of this component, saved this in its Saved: to be put into ours as
  /// far as it is still right. Between initialize() and start(). What is refused here is not restored, which
  /// is said; the module starts all the same. What was saved with our own version is there without being
  /// asked for. An instance that is swapped in is asked again, also after start(), until what it is given is
  /// the newest; there a refusal ends the swap.
  virtual Result<void> restore(const SavedBefore& before);
  /// Every module of the device is initialised.
  virtual Result<void> start() { return {}; }
  /// Every period, or when condition() holds. No lock, no allocation, no system call, no log.
  virtual void run(const Cycle& cycle) = 0;
  /// Sporadic modules: whether run() is to be called. Same rules as run(). Unless it is overridden: an event
  /// port has an event that was not read.
  virtual bool condition();
  /// An error took the module out of its table.
  virtual void error(ErrorType /*type*/) {}
  /// Makes it fit to run again, or says why not.
  virtual Result<void> recover() { return {}; }
  /// The last call.
  virtual void destruct() {}

  [[nodiscard]] const std::vector<PropertyBase*>& properties() const noexcept { return properties_; }
  [[nodiscard]] const std::vector<PortBase*>& ports() const noexcept { return ports_; }
  /// Those that a handler answers.
  [[nodiscard]] const std::vector<ServiceBase*>& services() const noexcept { return services_; }
  /// What it saves; one at most is right.
  [[nodiscard]] const std::vector<SavedBase*>& saved() const noexcept { return saved_; }

 protected:
  /// Of this module, in every hook: what initialize() holds its properties against. 0 of a module that has
  /// none; in run() and condition() of a sporadic one, of its executor's rows. Real-time.
  static Nanoseconds period() noexcept;
  /// From run() or condition(): takes the module out of its table after this call, with this reason (255
  /// bytes are kept). Real-time.
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

/// What a .so of a C++ component exports.
struct ComponentFactory {
  static constexpr std::uint32_t kAbi = 5;
  std::uint32_t abi;
  std::uint32_t component_size;  ///< sizeof(Component) when the object was compiled
  const char* name;              ///< of the class
  Component* (*create)();
  void (*destroy)(Component*);
  bool own_condition;  ///< condition() is overridden
};

namespace detail {
template <class Type>
constexpr bool overrides_condition() {
  if constexpr (requires { &Type::condition; })
    return !std::is_same_v<decltype(&Type::condition), bool (Component::*)()>;
  else
    return true;  // it is there and private
}
}  // namespace detail

}  // namespace takt

/// Once in each component's source, outside any namespace. The second argument, which may be left out, is one
/// sentence that says what the component does, for `takt describe`.
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
