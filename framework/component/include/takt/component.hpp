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
// In CMake, takt_add_component(ramp ramp.cpp) builds this component. A cell may have several modules of one
// component; each module is a separate object.
#pragma once

#ifndef __cplusplus
#error <takt/component.hpp> is for C++: a component in C includes <takt/module.h>
#endif
#ifdef TAKT_PROCESS_MODULE
#error <takt/component.hpp> is for components: use takt_add_component; a program includes <takt/process.hpp> or <takt/process.h>
#endif

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include <takt/text.h>
#include <takt/component/event_port.hpp>
#include <takt/component/in_port.hpp>
#include <takt/component/log.hpp>
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
  std::uint64_t number = 0;  ///< n: the number of the release, from 0; missed releases count, too. For a
                             ///< sporadic module, the number of the executor's row that released it (with
                             ///< immediate dispatch, of the next row)
  Instant time{};            ///< when the release was due; the same for all modules of a row
  Nanoseconds period{};      ///< period of the module; for a sporadic module, the basic period of its
                             ///< executor
  Instant start{};           ///< when run() was called; written samples get this time as their stamp

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
  deadline = 6,  ///< a sporadic module missed its deadline, with miss="error"
  stale = 7,     ///< an input was older than its connection's deadline, with stale="error"
  overrun = 8,   ///< a release was not served in time, and the descriptor makes that an error
};
/// Returns the name of the type: "failure", "budget", ...
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
  /// Called between initialize() and start() if a former instance of the module saved a value with another
  /// version or size. Copy the parts of `before` that are still valid into the Saved member of this instance.
  /// If restore() fails, the value is not restored, Takt reports the reason, and the module starts
  /// nevertheless. A value of the same version and size is restored without this call. During a swap,
  /// restore() is called again, also after start(), until the new instance has the newest value; a failure
  /// then ends the swap. The calling thread is not real-time. The default implementation fails.
  virtual Result<void> restore(const SavedBefore& before);
  /// Called when every module of the device is initialized. start() may fail. The calling thread is not
  /// real-time.
  virtual Result<void> start() { return {}; }
  /// Called every period, or when condition() is true. The calling thread is real-time, so run() must not
  /// lock, allocate or make a system call. It reports failures with fail(), and writes log lines with log().
  virtual void run(const Cycle& cycle) = 0;
  /// Called for a sporadic module. Returns true if run() must be called. The default implementation returns
  /// true while an event port has an unread event. The calling thread is real-time, so the rules of run()
  /// apply.
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
  /// All Saved members. A valid component has at most one.
  [[nodiscard]] const std::vector<SavedBase*>& saved() const noexcept { return saved_; }

 protected:
  /// Returns the period of this module, or 0 if it has none. Every hook may call it; initialize() can check
  /// properties against the period. In run() and condition() of a sporadic module, it returns the basic
  /// period of the executor. A real-time thread may call it.
  static Nanoseconds period() noexcept;
  /// Reports a failure from run() or condition(). After the hook, Takt takes the module out of its table,
  /// with `text` as the reason (at most 255 bytes). fail() returns to the hook, which should then return,
  /// too. A real-time thread may call it.
  static void fail(const char* text) noexcept;
  /// Reports from run() that the module has finished its work. This run() is then the last one: Takt takes
  /// the module out of its table, calls destruct(), and the module is in DESTRUCT until it is reset. Samples
  /// that run() writes after finish() are sent, too. finish() returns to run(), which should then return,
  /// too. If run() calls finish() and fails, Takt treats it as failed, not as finished. Outside of run(),
  /// finish() has no effect. A real-time thread may call it.
  static void finish() noexcept;
  /// The log of this module: `log().info("lost the part at {:.2f} m", x);`. A real-time thread may call it.
  static Log log() noexcept { return {}; }
  /// Makes the compiler reject a call such as log(text) or log(x), with a message that states what to write
  /// instead.
  template <class T>
  static void log(const T& /*text*/) {
    static_assert(detail::kIsLiteral<T>,
                  "log() has no arguments; write log().info(\"{}\", text), or std::log(x) for the logarithm");
  }
  /// Reports whether this module is in a safe stop. In a safe stop, a module works as intended, and keeps its
  /// machine stopped for safety. `takt status`, `takt watch`, `takt log` and the web page show the safe stop
  /// while the module is in EXECUTING. A reset of the module ends the safe stop. A real-time thread may call
  /// it.
  static void safe_stop(bool stopped) noexcept { takt::safe_stop(stopped); }

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

/// The data that the .so of a C++ component exports to the host. TAKT_COMPONENT defines an object of this
/// type.
struct ComponentFactory {
  static constexpr std::uint32_t kAbi = 5;  ///< version of this interface
  std::uint32_t abi;                        ///< kAbi when the component was compiled
  std::uint32_t component_size;             ///< sizeof(Component) when the component was compiled
  const char* name;                         ///< name of the class
  Component* (*create)();                   ///< creates an object of the class
  void (*destroy)(Component*);              ///< destroys an object that create() created
  bool own_condition;                       ///< true if the class overrides condition()
};

namespace detail {
template <class Type>
constexpr bool overrides_condition() {
  if constexpr (requires { &Type::condition; })
    return !std::is_same_v<decltype(&Type::condition), bool (Component::*)()>;
  else
    return true;  // condition() is a private member of Type, so Type overrides it
}

template <class Type>
inline constexpr bool kNever = false;

template <class Type>
Component* create() {
  Component* created = nullptr;
  if constexpr (!std::is_base_of_v<Component, Type>)
    static_assert(kNever<Type>, "derive the class of TAKT_COMPONENT from takt::Component");
  else if constexpr (std::is_abstract_v<Type>)
    static_assert(
        kNever<Type>,
        "the class of TAKT_COMPONENT has no run(); write void run(const takt::Cycle& cycle) override");
  else if constexpr (!std::is_default_constructible_v<Type>)
    static_assert(kNever<Type>, "the class of TAKT_COMPONENT needs a public constructor without arguments");
  else
    created = new Type;
  return created;
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
        &::takt::detail::create<Type>,                                              \
        [](::takt::Component* component) { delete component; },                     \
        ::takt::detail::overrides_condition<Type>()};                               \
    return &factory;                                                                \
  }
