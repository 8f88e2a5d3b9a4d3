// For the files in this folder that replace functions of Fast DDS.
#pragma once

#include <fastrtps/config.h>

#include <takt/core/check.hpp>
#include <takt/os/library.hpp>

#if FASTRTPS_VERSION_MAJOR != 2 || FASTRTPS_VERSION_MINOR != 9
#error "this folder replaces functions of Fast DDS 2.9; for another version, see workarounds/README.md"
#endif

namespace takt::dds {

/// Returns the function of Fast DDS that this process replaces, from its mangled name. Ends the process if
/// Fast DDS has no such function. Member functions get the object as their first parameter.
template <class Function>
Function* replaced(const char* name) noexcept {
  auto* const function = reinterpret_cast<Function*>(os::next_function(name));
  TAKT_CHECK(function != nullptr);
  return function;
}

}  // namespace takt::dds
