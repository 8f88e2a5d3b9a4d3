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
  /// Unloads; its destructors run.
  ~Library();

  /// Fails with the loader's reason, or, for `own`, when the object has symbols that the loader would share
  /// between copies (STB_GNU_UNIQUE, from inline variables and templates of C++).
  static Result<Library> open(const std::string& path, Globals globals);

  /// A file of this name, or this file by another name, is loaded already: `shared` would be that object,
  /// even where another file has taken its name since.
  static bool is_loaded(const std::string& path) noexcept;

  /// The address of a function or variable that this object itself defines; null when it does not. A symbol
  /// of one of the libraries it was linked with does not count: the C library too has a function `error`.
  [[nodiscard]] void* own_symbol(const char* name) const noexcept;

  /// Never unloads: for an object in which a thread may still be.
  void abandon() noexcept { handle_ = nullptr; }

 private:
  void* handle_ = nullptr;
};

/// The address of a function of any object that is loaded globally in this process; null if there is none.
void* loaded_function(const char* name) noexcept;

}  // namespace takt::os
