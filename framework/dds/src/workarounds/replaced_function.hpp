// For the files in this folder that replace functions of Fast DDS. Fast DDS 3 does not install the headers of
// most classes, so these files declare a function by its mangled name, as a function that gets the object as
// its first parameter:
//
//   bool remove(void* object, const rtps::GUID_t&) asm(TAKT_RTPS "3PDP6removeERKNS1_6GUID_tE");
#pragma once

#include <takt/core/check.hpp>
#include <takt/os/library.hpp>
#include "../fast_dds.hpp"

#if TAKT_FASTDDS == 2
#include <fastdds/rtps/writer/RTPSWriter.h>
#include <fastrtps/config.h>
#if FASTRTPS_VERSION_MAJOR != 2 || (FASTRTPS_VERSION_MINOR != 9 && FASTRTPS_VERSION_MINOR != 11)
#error "this folder replaces functions of Fast DDS 2.9, 2.11 and 3.1; see workarounds/README.md"
#endif
/// How the mangled names of functions begin, up to the name of the class.
#define TAKT_RTPS "_ZN8eprosima8fastrtps4rtps"
#define TAKT_RTPS_CONST "_ZNK8eprosima8fastrtps4rtps"  // of constant functions
#define TAKT_VENDOR ""  // in version 3, some functions also get the vendor of the sender
#else
#include <fastdds/rtps/writer/RTPSWriter.hpp>
#define TAKT_RTPS "_ZN8eprosima7fastdds4rtps"
#define TAKT_RTPS_CONST "_ZNK8eprosima7fastdds4rtps"
#define TAKT_VENDOR "St5arrayIhLm2EE"
#endif
#define TAKT_DDS "_ZN8eprosima7fastdds3dds"

namespace takt::dds {

/// Returns the function of Fast DDS that this process replaces, from its mangled name. Ends the process if
/// Fast DDS has no such function. Member functions get the object as their first parameter.
template <class Function>
Function* replaced(const char* name) noexcept {
  auto* const function = reinterpret_cast<Function*>(os::next_function(name));
  TAKT_CHECK(function != nullptr);
  return function;
}

/// Returns the GUID of a writer from the first parameter of one of its functions.
inline const rtps::GUID_t& guid_of(const void* writer) {
  return static_cast<const rtps::RTPSWriter*>(writer)->getGuid();
}

}  // namespace takt::dds
