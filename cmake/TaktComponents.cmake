# CMake functions for the authors of components:
#
#   takt_add_component(servo servo.cpp ... [TYPES types ...])   builds a thread module: servo.so
#   takt_add_process(vision vision.cpp ... [TYPES types ...])   builds a process module: vision.exe
#   takt_add_component_test(servo servo_test.cpp ...)           builds its tests, with GoogleTest and <takt/testing.hpp>
#
# The functions ignore CMAKE_UNITY_BUILD, because an author's sources may not compile as a unity build.
#
# Components are built into ${TAKT_COMPONENT_DIR}, by default the folder `components` of the build tree. TYPES names the libraries of
# takt_add_idl() that contain the types of the ports.

set(TAKT_COMPONENT_DIR ${CMAKE_BINARY_DIR}/components CACHE PATH "Folder into which components are built")

# Fails if `name`, the first argument of `command`, is a file instead of a name, or if another target has this name. `example` is a name that
# fits a file STEM.EXTENSION.
function(takt_check_name command name example)
  if(name MATCHES "^(.*/)?([^/]+)\\.(c|cc|cpp|cxx|idl)$")
    string(REPLACE STEM ${CMAKE_MATCH_2} example ${example})
    message(FATAL_ERROR "${command}(${name}): the first argument must be a name, not a file; write ${command}(${example} ${name} ...)")
  elseif(name MATCHES "^(.*/)?([^/]+)\\.(so|exe)$")
    message(FATAL_ERROR "${command}(${name}): Takt adds .${CMAKE_MATCH_3} to the name; write ${command}(${CMAKE_MATCH_2} ...)")
  elseif(name MATCHES "^(NAME|TYPES)$")
    message(FATAL_ERROR "${command}(${name}): the first argument must be a name, without a word before it; write ${command}(servo ...)")
  elseif(TARGET ${name})
    get_target_property(folder ${name} SOURCE_DIR)
    message(FATAL_ERROR "${command}(${name}): ${folder}/CMakeLists.txt already has a target of this name; change the name here or there")
  endif()
endfunction()

# Checks the further arguments, the TYPES of the component `name`: each must be a target, normally a library of takt_add_idl(). The check runs at the end of the
# configuration, because a later command may add the library.
function(takt_check_types name)
  foreach(library IN LISTS ARGN)
    if(NOT TARGET ${library})
      cmake_language(EVAL CODE "cmake_language(DEFER DIRECTORY [[${CMAKE_SOURCE_DIR}]] CALL takt_no_such_types [[${name}]] [[${library}]])")
    endif()
  endforeach()
endfunction()

function(takt_no_such_types name library)
  if(TARGET ${library})
    return()
  endif()
  get_property(types GLOBAL PROPERTY TAKT_TYPES)
  if(library MATCHES "\\.idl$")
    set(cure "call takt_add_idl(${name}_types ${library}), and write TYPES ${name}_types")
  elseif(types)
    list(JOIN types " or " types)
    set(cure "write ${types}, or call takt_add_idl(${library} ...)")
  else()
    set(cure "call takt_add_idl(${library} ...)")
  endif()
  message(FATAL_ERROR "${name}: TYPES ${library} is not a library of port types; ${cure}")
endfunction()

# Fails if one of the further arguments is not a source file; they are the sources that `command` was given for `name`. The message ends with
# the advice `cure`. If `keyword` is true and the argument resembles TYPES, the message suggests TYPES instead.
function(takt_check_sources command name keyword cure)
  if(NOT ARGN)
    message(FATAL_ERROR "${command}(${name}) has no source file; write ${command}(${name} ${name}.cpp ...)")
  endif()
  foreach(source IN LISTS ARGN)
    if(source MATCHES "[./$]" OR source STREQUAL "EXCLUDE_FROM_ALL")
      continue()
    endif()
    string(TOUPPER ${source} upper)
    if(keyword AND upper MATCHES "^T[YPE]+S*$")
      set(cure "did you mean TYPES?")
    endif()
    message(FATAL_ERROR "${command}(${name}): ${source} is not a source file; ${cure}")
  endforeach()
endfunction()

# Sets the compile options of components.
#
# A log call whose arguments do not fit its format would crash, so it is an error.
#
# The first option keeps each calling function on the stack, also for a call that is its last action, so that Takt can name the function if the
# call crashes, hangs or is not allowed in real-time code. The folder of the second option contains a header with a message for each header
# that a component can include only with TYPES.
set(TAKT_HEADERS_WITHOUT_TYPES ${CMAKE_BINARY_DIR}/takt_headers_without_types)
function(takt_set_options target)
  target_compile_options(${target} PRIVATE -fno-optimize-sibling-calls -Werror=format "SHELL:-idirafter \"${TAKT_HEADERS_WITHOUT_TYPES}\"")
endfunction()

function(takt_add_component name)
  takt_check_name(takt_add_component ${name} STEM)
  cmake_parse_arguments(MODULE "" "" "TYPES" ${ARGN})
  takt_check_sources(takt_add_component ${name} TRUE "libraries of port types follow the word TYPES" ${MODULE_UNPARSED_ARGUMENTS})
  takt_check_types(${name} ${MODULE_TYPES})
  add_library(${name} MODULE ${MODULE_UNPARSED_ARGUMENTS})
  # Two modules of the same .so file must not share variables, but the loader would share GNU_UNIQUE symbols.
  target_compile_options(${name} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-gnu-unique>)
  takt_set_options(${name})
  set_property(GLOBAL APPEND PROPERTY TAKT_COMPONENTS ${name})
  target_link_libraries(${name} PRIVATE takt_component ${MODULE_TYPES})
  # <takt/process.h> rejects a source with this symbol, because programs are built with takt_add_process().
  set_target_properties(${name} PROPERTIES PREFIX "" SUFFIX ".so" LIBRARY_OUTPUT_DIRECTORY ${TAKT_COMPONENT_DIR}
                        DEFINE_SYMBOL TAKT_THREAD_MODULE UNITY_BUILD OFF)
  if(COMMAND takt_precompile)  # only Takt's own build has this command
    takt_precompile(${name} component takt/component.hpp)
  endif()
endfunction()

function(takt_add_process name)
  takt_check_name(takt_add_process ${name} STEM)
  cmake_parse_arguments(MODULE "" "" "TYPES" ${ARGN})
  takt_check_sources(takt_add_process ${name} TRUE "libraries of port types follow the word TYPES" ${MODULE_UNPARSED_ARGUMENTS})
  takt_check_types(${name} ${MODULE_TYPES})
  add_executable(${name} ${MODULE_UNPARSED_ARGUMENTS})
  takt_set_options(${name})
  set_property(GLOBAL APPEND PROPERTY TAKT_COMPONENTS ${name})
  target_link_libraries(${name} PRIVATE takt_process ${MODULE_TYPES})
  # <takt/component.hpp> and <takt/module.h> reject a source with this definition.
  target_compile_definitions(${name} PRIVATE TAKT_PROCESS_MODULE)
  set_target_properties(${name} PROPERTIES SUFFIX ".exe" RUNTIME_OUTPUT_DIRECTORY ${TAKT_COMPONENT_DIR} UNITY_BUILD OFF)
endfunction()

# The tests are named servo.SUITE.TEST in CTest. A process module is compiled a second time for its tests, as a library whose main() the
# tests call. Call this function after all other commands for the component. Without GoogleTest (Debian: libgtest-dev), this function does nothing.
function(takt_add_component_test name)
  get_property(components GLOBAL PROPERTY TAKT_COMPONENTS)
  if(NOT name IN_LIST components)
    set(cure "; call")
    if(components)
      list(JOIN components ", " components)
      set(cure " (there are: ${components}); correct the name, or call")
    endif()
    message(FATAL_ERROR "takt_add_component_test(${name}): there is no component ${name}${cure} takt_add_component(${name}) or "
                        "takt_add_process(${name}) first")
  endif()
  takt_check_sources(takt_add_component_test ${name} FALSE "remove it: a test has the port types of its component" ${ARGN})
  # A test calls its component from one thread, on virtual time, so ThreadSanitizer has nothing to check.
  if(TAKT_SANITIZE STREQUAL "thread")
    return()
  endif()
  find_package(GTest QUIET)
  if(NOT GTest_FOUND)
    message(STATUS "GoogleTest is not installed: the tests of ${name} are not built")
    return()
  endif()
  include(GoogleTest)

  set(libraries "$<FILTER:$<TARGET_PROPERTY:${name},LINK_LIBRARIES>,EXCLUDE,takt_(component|process)$>")
  set(tested ${name})
  get_target_property(type ${name} TYPE)
  if(type STREQUAL "EXECUTABLE")
    set(tested ${name}_as_library)
    get_target_property(sources ${name} SOURCES)
    add_library(${tested} MODULE ${sources})
    set_target_properties(${tested} PROPERTIES PREFIX "" OUTPUT_NAME ${name} SUFFIX ".exe.so"
                          LIBRARY_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR} UNITY_BUILD OFF)
    foreach(property COMPILE_OPTIONS COMPILE_DEFINITIONS COMPILE_FEATURES INCLUDE_DIRECTORIES)
      set_target_properties(${tested} PROPERTIES ${property} "$<TARGET_PROPERTY:${name},${property}>")
    endforeach()
    target_compile_options(${tested} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-gnu-unique>)
    # The module's calls of exit() and atexit() must not affect the test program.
    target_link_options(${tested} PRIVATE -Wl,--wrap=exit,--wrap=atexit)
    target_link_libraries(${tested} PRIVATE takt_testing ${libraries})
  endif()

  set(file ${CMAKE_CURRENT_BINARY_DIR}/${name}_tested.cpp)
  file(GENERATE OUTPUT ${file} CONTENT "#include <takt/testing/tested_file.hpp>
namespace { const takt::testing::detail::TestedFile file{\"$<TARGET_FILE:${tested}>\"}; }
")
  add_executable(${name}_test ${ARGN} ${file})
  set_target_properties(${name}_test PROPERTIES UNITY_BUILD OFF)
  add_dependencies(${name}_test ${tested})
  target_link_libraries(${name}_test PRIVATE takt_testing ${libraries} GTest::gmock GTest::gtest_main)
  if(COMMAND takt_discover_tests)  # only Takt's own build has this command
    target_compile_options(${name}_test PRIVATE -O0)
    takt_discover_tests(${name}_test PREFIX ${name}. TIMEOUT 120)
  else()
    gtest_discover_tests(${name}_test DISCOVERY_MODE PRE_TEST TEST_PREFIX ${name}. PROPERTIES TIMEOUT 120)
  endif()
  set_property(GLOBAL APPEND PROPERTY TAKT_COMPONENT_TESTS ${name}_test)
  cmake_language(EVAL CODE "cmake_language(DEFER DIRECTORY [[${CMAKE_SOURCE_DIR}]]
                                           CALL takt_check_testing [[${name}]] [[${CMAKE_CURRENT_SOURCE_DIR}]])")
endfunction()

# Warns if ctest will not find the tests of a component in `folder`. With BUILD_TESTING=OFF, that is intended.
function(takt_check_testing name folder)
  get_directory_property(here DIRECTORY ${folder} DEFINITION CMAKE_TESTING_ENABLED)
  get_directory_property(top DIRECTORY ${CMAKE_SOURCE_DIR} DEFINITION CMAKE_TESTING_ENABLED)
  if(NOT (here AND top) AND NOT (DEFINED BUILD_TESTING AND NOT BUILD_TESTING))
    message(WARNING "takt_add_component_test(${name}): ctest will not find these tests; call enable_testing() in "
                    "${CMAKE_SOURCE_DIR}/CMakeLists.txt, before add_subdirectory()")
  endif()
endfunction()
