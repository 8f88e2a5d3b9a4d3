// takt::Saved: the state of a module that survives the death of the module's process, so that outputs do not
// jump.
//
//   struct Kept { double sum = 0; std::uint64_t pieces = 0; };
//   takt::Saved<Kept> kept{*this, 1};      1 is the version of Kept: increase it when its meaning changes
//   ...
//   kept->sum += error * cycle.seconds();  in run()
//
// After each run() that did not fail, Takt copies the value into memory that outlives the process. After a
// crash, the new instance has the saved value from start() on; initialize() is called before the value is
// restored. With <retain>true</retain> in the descriptor the value is also written to disk and survives
// power-off.
//
// In a process module, `kept` is a global variable and is constructed with kept{1}. Each waitPeriod() or
// waitSporadic() except the first copies the value. After a crash, the restarted program has the saved value
// when initPeriodExe() or initSporadicExe() returns.
#pragma once

#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include <takt/channel/saved_state.hpp>
#include <takt/component/owner.hpp>

namespace takt {

class Component;

/// The part of Saved that does not depend on the type of the value.
class SavedBase {
 public:
  SavedBase(const SavedBase&) = delete;
  SavedBase& operator=(const SavedBase&) = delete;

  /// The version of the value's meaning, which the author increases when the meaning changes.
  [[nodiscard]] std::uint32_t version() const noexcept { return version_; }
  /// The address of the value.
  [[nodiscard]] void* data() const noexcept { return data_; }
  /// The size of the value in bytes.
  [[nodiscard]] std::uint32_t size() const noexcept { return size_; }
  /// True if this object has the value that a former instance of the module saved last. Valid from start()
  /// on; in a process module, after initPeriodExe() or initSporadicExe(). A real-time thread may call it.
  [[nodiscard]] bool restored() const noexcept { return restored_; }

  /// Sets the result of restored(). Only the code that runs the module calls this function.
  void set_restored(bool restored) noexcept { restored_ = restored; }

 protected:
  /// `owner` is null in a process module.
  SavedBase(Component* owner, void* data, std::uint32_t size, std::uint32_t version);
  ~SavedBase();

 private:
  void* data_;
  std::uint32_t size_;
  std::uint32_t version_;
  bool owned_;
  bool restored_ = false;
};

/// Returns the Saved objects that belong to no component: in a process module, all its Saved objects; in a
/// host, those of the module in C form that this thread has loaded since the last call.
std::vector<SavedBase*> take_loose_saved();

namespace detail {
void add_loose_saved(SavedBase& saved);
void remove_loose_saved(SavedBase& saved) noexcept;
}  // namespace detail

/// The saved state of a module: a member of a component, or a global variable of a process module. A
/// component or process module has at most one Saved. T is copied byte by byte into another process, so T
/// must not contain pointers or containers, and it has at most 4096 bytes. Every hook may use the value,
/// including run() on the real-time thread.
template <class T>
class Saved : public SavedBase {
  static_assert(std::is_trivially_copyable_v<T>,
                "T is saved byte by byte; use numbers, and arrays and structs of numbers");
  static_assert(sizeof(T) <= channel::kMostSaved, "T is too large; at most 4096 bytes are saved");

 public:
  /// Constructs the saved state of a component, as a member. Increase `version` whenever the meaning of T
  /// changes. `initial` is the value of a new instance.
  Saved(detail::Owner owner, std::uint32_t version, T initial = T{})
      : SavedBase(owner.component(), &value_, sizeof(T), version), value_(std::move(initial)) {}
  /// Constructs the saved state of a process module, as a global variable. `version` and `initial` have the
  /// same meaning as for a component.
  explicit Saved(std::uint32_t version, T initial = T{})
      : SavedBase(nullptr, &value_, sizeof(T), version), value_(std::move(initial)) {
    static_assert(detail::InProgram<T>,
                  "pass *this as the first argument: takt::Saved<T> kept{*this, 1}; only a program, which "
                  "includes <takt/process.hpp>, omits it");
  }
  /// Returns the value. A real-time thread may call it.
  T* operator->() noexcept { return &value_; }
  /// Returns the value. A real-time thread may call it.
  const T* operator->() const noexcept { return &value_; }
  /// Returns the value. A real-time thread may call it.
  T& operator*() noexcept { return value_; }
  /// Returns the value. A real-time thread may call it.
  const T& operator*() const noexcept { return value_; }

 private:
  T value_;
};

/// The value that a former instance saved with another version or size, see Component::restore().
struct SavedBefore {
  std::uint32_t version;  ///< the version with which the value was saved
  const void* data;       ///< the saved bytes; valid only during restore()
  std::uint32_t size;     ///< number of bytes
};

}  // namespace takt
