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
    shared,  ///< loading the same file again gives the same object in memory
    own,     ///< each load gets its own copy of all global variables
  };

  Library() = default;
  Library(Library&& other) noexcept;
  Library& operator=(Library&& other) noexcept;
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  /// Unloads the object, and runs the destructors of its global variables.
  ~Library();

  /// Loads an object. If this fails, the problem contains the loader's reason. With `own`, also fails if the
  /// object has symbols that the loader would share between copies (STB_GNU_UNIQUE, from inline variables and
  /// templates of C++).
  static Result<Library> open(const std::string& path, Globals globals);

  /// Returns true if a file with this path, or the same file under another path, is already loaded. In that
  /// case, open() with `shared` returns the loaded object, even if the path now names another file.
  static bool is_loaded(const std::string& path) noexcept;

  /// The address of a function or variable that this object itself defines; null if it does not define it.
  /// Symbols of the libraries that the object is linked with are ignored. For example, the C library also
  /// defines a function `error`.
  [[nodiscard]] void* own_symbol(const char* name) const noexcept;

  /// Keeps the object loaded forever, because a thread may still run its code.
  void abandon() noexcept { handle_ = nullptr; }

 private:
  void* handle_ = nullptr;
};

/// The address of a function with this name in any object that is loaded globally in this process; null if
/// there is none.
void* loaded_function(const char* name) noexcept;

}  // namespace takt::os
