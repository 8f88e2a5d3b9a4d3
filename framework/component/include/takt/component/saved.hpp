// What a module keeps when its process dies, so that its outputs do not jump:
//
//   struct Kept { double sum = 0; std::uint64_t pieces = 0; };
//   takt::Saved<Kept> kept{*this, 1};      1 is the version of Kept: count it up when its meaning changes
//   ...
//   kept->sum += error * cycle.seconds();  in run()
//
// After each run() that did not fail the value is copied into memory that outlives the process. An instance
// that takes the place of one that crashed finds it there in start(): initialize() was called before, as
// ever. With <retain>true</retain> it is on disk as well, for when the machine was switched off.
//
// Of a program it is a global variable, kept{1}: copied in each waitPeriod() or waitSporadic() but the first,
// and there again when initPeriodExe() or initSporadicExe() returns.
#pragma once

#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include <takt/channel/saved_state.hpp>

namespace takt {

class Component;

/// The part that does not depend on the type.
class SavedBase {
 public:
  SavedBase(const SavedBase&) = delete;
  SavedBase& operator=(const SavedBase&) = delete;

  [[nodiscard]] std::uint32_t version() const noexcept { return version_; }
  [[nodiscard]] void* data() const noexcept { return data_; }
  [[nodiscard]] std::uint32_t size() const noexcept { return size_; }
  /// The value is what a former instance saved last. From start() on; of a program from initPeriodExe() on.
  [[nodiscard]] bool restored() const noexcept { return restored_; }

  // For whoever runs the module.
  void set_restored(bool restored) noexcept { restored_ = restored; }

 protected:
  /// Without an owner it is a program's.
  SavedBase(Component* owner, void* data, std::uint32_t size, std::uint32_t version);
  ~SavedBase();

 private:
  void* data_;
  std::uint32_t size_;
  std::uint32_t version_;
  bool owned_;
  bool restored_ = false;
};

/// Those without an owner that were constructed since; none afterwards. Of the calling thread.
std::vector<SavedBase*> take_loose_saved();

namespace detail {
void add_loose_saved(SavedBase& saved);
void remove_loose_saved(SavedBase& saved) noexcept;
}  // namespace detail

/// A member of a component, or a global variable of a program; each has one at most. T is copied byte by byte
/// into another process: no pointers, no containers. For every hook, run() included.
template <class T>
class Saved : public SavedBase {
  static_assert(std::is_trivially_copyable_v<T>,
                "what is saved is copied byte by byte: numbers, arrays and structs of these");
  static_assert(sizeof(T) <= channel::kMostSaved, "at most 4096 bytes are saved");

 public:
  Saved(Component& owner, std::uint32_t version, T initial = T{})
      : SavedBase(&owner, &value_, sizeof(T), version), value_(std::move(initial)) {}
  explicit Saved(std::uint32_t version, T initial = T{})
      : SavedBase(nullptr, &value_, sizeof(T), version), value_(std::move(initial)) {}
  T* operator->() noexcept { return &value_; }
  const T* operator->() const noexcept { return &value_; }
  T& operator*() noexcept { return value_; }
  const T& operator*() const noexcept { return value_; }

 private:
  T value_;
};

/// What an instance of another version saved.
struct SavedBefore {
  std::uint32_t version;
  const void* data;
  std::uint32_t size;  ///< bytes
};

}  // namespace takt
