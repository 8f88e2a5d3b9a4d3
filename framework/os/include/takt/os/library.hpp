// Loads shared objects at run time.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

class Library {
 public:
  enum class Globals {
    shared,  ///< a second load of the same file gives the same object in memory
    own,     ///< this load has its own copy of all global variables
  };

  Library() = default;
  Library(Library&& other) noexcept;
  Library& operator=(Library&& other) noexcept;
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  /// Unloads the object; the destructors of its globals run.
  ~Library();

  /// Loads an object. Fails with the loader's reason. With `own`, also fails if the object has symbols that
  /// the loader would share between copies (STB_GNU_UNIQUE, from inline variables and templates of C++).
  static Result<Library> open(const std::string& path, Globals globals);

  /// Whether a file of this name, or this file under another name, is already loaded. If so, open() with
  /// `shared` returns that object, even if another file has this name now.
  static bool is_loaded(const std::string& path) noexcept;

  /// The address of a function or variable that this object itself defines; null if it does not define it.
  /// Symbols of the libraries that it is linked with do not count: the C library also has a function `error`.
  [[nodiscard]] void* own_symbol(const char* name) const noexcept;

  /// Leaves the object loaded forever, because a thread may still run its code.
  void abandon() noexcept { handle_ = nullptr; }

 private:
  void* handle_ = nullptr;
};

/// The address of a function of this name in any object that is loaded globally in this process. Null if
/// there is none.
void* loaded_function(const char* name) noexcept;

}  // namespace takt::os
