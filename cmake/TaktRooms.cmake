# A room is a folder of framework/ with one reason to exist. Each is one library with one include root, so a header of a
# room that was not named under USES is not found, and a library that belongs to another room does not compile.
#
#   takt_room(schedule USES core model [LINKS tinyxml2] [MAY_NAME tinyxml2 linux]
#             [NOT_REAL_TIME] [SHARED] [FOR_AUTHORS component.hpp ...] [EXCEPT other.cpp ...] [PRECOMPILED large.hpp ...])
#
# FOR_AUTHORS: headers that are found as <takt/NAME> too. EXCEPT: sources that are built elsewhere.
# Headers are included as <takt/ROOM/NAME.hpp>. The include root of a room holds nothing but a link to its folder.

set(TAKT_WARNINGS -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror)
# A unity source includes the sources it combines, so GCC takes their private types for those of a header.
if(CMAKE_UNITY_BUILD)
  list(APPEND TAKT_WARNINGS $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-subobject-linkage>)
endif()
# What no real-time thread calls is optimised for who waits for the build: it takes two thirds of the time.
if(CMAKE_BUILD_TYPE STREQUAL "RelWithDebInfo" AND NOT TAKT_SANITIZE AND NOT TAKT_FUZZ)
  set(TAKT_NOT_REAL_TIME -O1)
endif()

# Headers that only one room may name. A room that may not finds, first on its include path, a header of the same name
# that says so. What the C++ library itself includes (unistd.h, pthread.h, ...) is let through from there.
# Level 2 is an include in a header that a source includes; where sources are compiled together, it is one level deeper.
set(named "__INCLUDE_LEVEL__ <= 2 || (__INCLUDE_LEVEL__ == 3 && defined(TAKT_TOGETHER))")
set(TAKT_GUARDED_tinyxml2 tinyxml2.h)
# All of Fast DDS, but for the text of fixed size that generated types are made of.
find_path(TAKT_FASTDDS_INCLUDE fastdds/dds/domain/DomainParticipant.hpp)
file(GLOB_RECURSE TAKT_GUARDED_fastdds RELATIVE ${TAKT_FASTDDS_INCLUDE} ${TAKT_FASTDDS_INCLUDE}/fastdds/*.h*
     ${TAKT_FASTDDS_INCLUDE}/fastrtps/*.h*)
list(REMOVE_ITEM TAKT_GUARDED_fastdds fastrtps/utils/fixed_size_string.hpp)
set(TAKT_GUARDED_linux dlfcn.h elf.h fcntl.h link.h linux/futex.h poll.h pthread.h sched.h signal.h spawn.h
    sys/epoll.h sys/eventfd.h sys/file.h sys/mman.h sys/prctl.h sys/resource.h sys/select.h sys/signalfd.h
    sys/socket.h sys/stat.h sys/syscall.h sys/timerfd.h sys/types.h sys/un.h sys/wait.h syscall.h ucontext.h
    unistd.h)
set(TAKT_OWNER_tinyxml2 "framework/descriptor")
set(TAKT_OWNER_fastdds "framework/dds")
set(TAKT_OWNER_linux "framework/os")

foreach(library tinyxml2 fastdds linux)
  foreach(header IN LISTS TAKT_GUARDED_${library})
    file(WRITE ${CMAKE_BINARY_DIR}/rooms/.guard/${library}/${header}.new
"#if ${named}
#error \"<${header}> is named only in ${TAKT_OWNER_${library}}; use that room's interface\"
#else
#include_next <${header}>
#endif
")
    file(COPY_FILE ${CMAKE_BINARY_DIR}/rooms/.guard/${library}/${header}.new
         ${CMAKE_BINARY_DIR}/rooms/.guard/${library}/${header} ONLY_IF_DIFFERENT)
  endforeach()
endforeach()

# takt_precompile(target KIND large.hpp ...): what takes long to read is read once for all targets of a kind, which are compiled with the
# same options. It hides nothing: the preset `debug` compiles each header of a room without.
function(takt_precompile target kind)
  get_target_property(sources ${target} SOURCES)
  if(TAKT_FUZZ OR TAKT_SANITIZE OR sources MATCHES "\\.c(;|$)")
    return()
  endif()
  get_property(first GLOBAL PROPERTY TAKT_PRECOMPILED_${kind})
  if(first)
    target_precompile_headers(${target} REUSE_FROM ${first})
  else()
    set_property(GLOBAL PROPERTY TAKT_PRECOMPILED_${kind} ${target})
    foreach(header IN LISTS ARGN)
      target_precompile_headers(${target} PRIVATE "$<$<COMPILE_LANGUAGE:CXX>:<${header}$<ANGLE-R>>")
    endforeach()
  endif()
  # GCC 12 forgets that what it precompiled are the system's headers, and warns of std::string in them.
  target_compile_options(${target} PRIVATE
    "$<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-array-bounds;-Wno-restrict;-Wno-stringop-overflow>")
endfunction()

# OpenSSL comes with Fast DDS, and its guard lies with that one's; the room that may name it says so by a definition.
find_path(TAKT_OPENSSL_INCLUDE openssl/x509.h)
file(GLOB headers RELATIVE ${TAKT_OPENSSL_INCLUDE} ${TAKT_OPENSSL_INCLUDE}/openssl/*.h)
foreach(header IN LISTS headers)
  file(WRITE ${CMAKE_BINARY_DIR}/rooms/.guard/fastdds/${header}.new
"#pragma GCC system_header
#if (${named}) && !defined(TAKT_MAY_NAME_OPENSSL)
#error \"<${header}> is named only in framework/security; use that room's interface\"
#else
#include_next <${header}>
#endif
")
  file(COPY_FILE ${CMAKE_BINARY_DIR}/rooms/.guard/fastdds/${header}.new
       ${CMAKE_BINARY_DIR}/rooms/.guard/fastdds/${header} ONLY_IF_DIFFERENT)
endforeach()

function(takt_room name)
  cmake_parse_arguments(ROOM "SHARED;NOT_REAL_TIME" "" "USES;LINKS;MAY_NAME;FOR_AUTHORS;EXCEPT;PRECOMPILED" ${ARGN})
  set(root ${CMAKE_BINARY_DIR}/rooms/${name})
  file(MAKE_DIRECTORY ${root}/takt)
  file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR}/${name} ${root}/takt/${name} SYMBOLIC)

  foreach(header IN LISTS ROOM_FOR_AUTHORS)
    file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR}/${name}/${header} ${root}/takt/${header} SYMBOLIC)
    set_property(GLOBAL APPEND PROPERTY TAKT_FOR_AUTHORS ${name}/${header})
  endforeach()

  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.cpp)
  file(GLOB headers CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.hpp)
  list(TRANSFORM ROOM_EXCEPT PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/${name}/)
  list(REMOVE_ITEM sources ${ROOM_EXCEPT})
  # Every header compiles on its own: each is the first include of its source, or of one that is made here. That shows only where sources
  # are compiled one by one, as the preset `debug` does.
  if(CMAKE_UNITY_BUILD OR TAKT_FUZZ)
    set(headers)
  endif()
  foreach(header IN LISTS headers)
    get_filename_component(stem ${header} NAME_WE)
    set(first)
    if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/${stem}.cpp AND NOT ROOM_PRECOMPILED)
      file(STRINGS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/${stem}.cpp first REGEX "^#include" LIMIT_COUNT 1)
    endif()
    if(first STREQUAL "#include <takt/${name}/${stem}.hpp>")
      continue()
    endif()
    set(alone ${root}/alone/${stem}.cpp)
    file(GENERATE OUTPUT ${alone} CONTENT "#include <takt/${name}/${stem}.hpp>\n")
    set_source_files_properties(${alone} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
    list(APPEND sources ${alone})
  endforeach()

  set(kind STATIC)
  if(ROOM_SHARED)
    set(kind SHARED)
  endif()
  add_library(takt_${name} ${kind} ${sources})
  set_target_properties(takt_${name} PROPERTIES UNITY_BUILD_CODE_BEFORE_INCLUDE "#define TAKT_TOGETHER 1")
  target_include_directories(takt_${name} PUBLIC ${root})
  target_compile_options(takt_${name} PRIVATE ${TAKT_WARNINGS})
  if(ROOM_NOT_REAL_TIME)
    target_compile_options(takt_${name} PRIVATE ${TAKT_NOT_REAL_TIME})
  endif()
  foreach(library tinyxml2 fastdds linux)
    if(NOT library IN_LIST ROOM_MAY_NAME)
      target_include_directories(takt_${name} BEFORE PRIVATE ${CMAKE_BINARY_DIR}/rooms/.guard/${library})
    endif()
  endforeach()
  if(openssl IN_LIST ROOM_MAY_NAME)
    target_compile_definitions(takt_${name} PRIVATE TAKT_MAY_NAME_OPENSSL)
  endif()
  foreach(room IN LISTS ROOM_USES)
    target_link_libraries(takt_${name} PUBLIC takt_${room})
  endforeach()
  target_link_libraries(takt_${name} PUBLIC ${ROOM_LINKS})
  if(ROOM_PRECOMPILED)
    takt_precompile(takt_${name} ${name} ${ROOM_PRECOMPILED})
  endif()
endfunction()
