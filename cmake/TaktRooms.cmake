# A room is a folder of framework/ with one purpose. Each room is one library, and contains README.md and
#
#   include/takt/ROOM/*.hpp   headers that other rooms may use, included as <takt/ROOM/NAME.hpp>
#   include/takt/*.hpp        headers for the authors of components, included as <takt/NAME.hpp>
#   src/                      sources, and headers that only this room uses, included as "NAME.hpp"
#
#   takt_room(schedule USES core model [PRIVATELY os] [LINKS tinyxml2] [OWNS tinyxml2]
#             [NOT_REAL_TIME] [SHARED] [EXCEPT other.cpp ...] [PRECOMPILED large.hpp ...])
#
# USES names the rooms that the room may include. PRIVATELY names the rooms that only its sources may include. OWNS names the libraries that
# no other room may include. EXCEPT names the sources that are not part of the library. check_includes.py rejects every other include before
# anything is compiled.

set(TAKT_WARNINGS -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror)
# A unity source includes the sources that it combines, so GCC treats types of an unnamed namespace as if a header declared them, and warns.
if(CMAKE_UNITY_BUILD)
  list(APPEND TAKT_WARNINGS $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-subobject-linkage>)
endif()
# Compiling code that no real-time thread calls takes two thirds of the build time. The option -O1 shortens this time.
if(CMAKE_BUILD_TYPE STREQUAL "RelWithDebInfo" AND NOT TAKT_SANITIZE)
  set(TAKT_NOT_REAL_TIME -O1)
endif()

# takt_precompile(target KIND large.hpp ...) precompiles large headers once for all targets of a kind, which are compiled with the same
# options. The preset `debug` compiles without precompiled headers, so that no source depends on them.
function(takt_precompile target kind)
  get_target_property(sources ${target} SOURCES)
  if(TAKT_SANITIZE OR NOT CMAKE_UNITY_BUILD OR sources MATCHES "\\.c(;|$)")
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
  # GCC 12 forgets that precompiled headers are system headers, and reports false warnings about std::string in them.
  target_compile_options(${target} PRIVATE
    "$<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-array-bounds;-Wno-restrict;-Wno-stringop-overflow>")
endfunction()

set(TAKT_ROOMS_FILE ${CMAKE_BINARY_DIR}/rooms.txt)
file(WRITE ${TAKT_ROOMS_FILE} "")
find_package(Python3 3.9 REQUIRED COMPONENTS Interpreter)
add_custom_target(takt_includes COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/check_includes.py
                                        ${CMAKE_SOURCE_DIR} ${TAKT_ROOMS_FILE} VERBATIM COMMENT "includes")

function(takt_room name)
  cmake_parse_arguments(ROOM "SHARED;NOT_REAL_TIME" "" "USES;PRIVATELY;LINKS;OWNS;EXCEPT;PRECOMPILED" ${ARGN})
  list(JOIN ROOM_OWNS "," owns)
  set(uses ${ROOM_USES} ${ROOM_PRIVATELY})
  list(JOIN uses "," uses)
  file(APPEND ${TAKT_ROOMS_FILE} "${name};${uses};${owns}\n")

  set(folder ${CMAKE_CURRENT_SOURCE_DIR}/${name})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${folder}/src/*.cpp)
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS ${folder}/include/*.hpp)
  list(TRANSFORM ROOM_EXCEPT PREPEND ${folder}/src/)
  list(REMOVE_ITEM sources ${ROOM_EXCEPT})
  if(ROOM_SHARED)
    set(kind SHARED)
  else()
    set(kind STATIC)
  endif()
  add_library(takt_${name} ${kind} ${sources})
  add_dependencies(takt_${name} takt_includes)
  # The preset `debug` compiles each of these headers alone.
  target_sources(takt_${name} PUBLIC FILE_SET HEADERS BASE_DIRS ${folder}/include FILES ${headers})
  target_compile_options(takt_${name} PRIVATE ${TAKT_WARNINGS} ${TAKT_FUZZED})
  if(ROOM_NOT_REAL_TIME)
    target_compile_options(takt_${name} PRIVATE ${TAKT_NOT_REAL_TIME})
  endif()
  list(TRANSFORM ROOM_USES PREPEND takt_)
  list(TRANSFORM ROOM_PRIVATELY PREPEND takt_)
  target_link_libraries(takt_${name} PUBLIC ${ROOM_USES} ${ROOM_LINKS} PRIVATE ${ROOM_PRIVATELY})
  if(ROOM_PRECOMPILED)
    takt_precompile(takt_${name} ${name} ${ROOM_PRECOMPILED})
  endif()
endfunction()
