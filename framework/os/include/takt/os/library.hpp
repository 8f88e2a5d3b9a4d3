// Loads shared objects at run time.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

class Library {
 public:
  enum class Globals {
    shared,  ///< loading the same file again gives the same object in memory
    own,     ///< each load gives a new object with its own copy of all global variables
  };

  /// Whether the object finds libraries in folders relative to that of the file at `path` ($ORIGIN).
  enum class Origin { searched, ignored };

  Library() = default;
  Library(Library&& other) noexcept;
  Library& operator=(Library&& other) noexcept;
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  /// Unloads the object, and runs the destructors of its global variables.
  ~Library();

  /// Loads a shared object from a sealed copy of the file at `path`: the given one, or a new one. So a
  /// program that overwrites the file cannot change the loaded code. If this fails, the problem contains the
  /// loader's reason. With Globals::own, also fails if the object has symbols that the loader would share
  /// between copies (STB_GNU_UNIQUE, from inline variables and templates of C++).
  static Result<Library> open(const std::string& path, Globals globals, Fd copy = {},
                              Origin origin = Origin::searched);

  /// Returns true if the file at this path is already loaded with Globals::shared. Then open() with
  /// Globals::shared returns the loaded object, even if the file at this path has changed.
  static bool is_loaded(const std::string& path);

  /// Returns the address of a function or variable that this object itself defines; null if the object
  /// defines none with this name. Ignores symbols of the libraries that the object is linked with; for
  /// example, the C library also defines a function `error`.
  [[nodiscard]] void* own_symbol(const char* name) const noexcept;

  /// Prevents the destructor from unloading the object. Used if a thread may still run the object's code.
  void abandon() noexcept { handle_ = nullptr; }

 private:
  std::shared_ptr<Fd> copy_;  // stays open, because its path is the name of the object
  void* handle_ = nullptr;
};

/// Returns the address of a function with this name in any object that is loaded globally in this process;
/// null if there is none.
void* loaded_function(const char* name) noexcept;
/// Returns the address of the next function with this name in the search order of the loader, after the
/// calling program or library; null if there is none. In this way, a library that replaces a function of
/// another library finds the original function.
void* next_function(const char* name) noexcept;

}  // namespace takt::os
