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

set(TAKT_COMPONENT_DIR ${CMAKE_BINARY_DIR}/components CACHE PATH "Where components are built to")

function(takt_add_component name)
  cmake_parse_arguments(MODULE "" "" "TYPES" ${ARGN})
  add_library(${name} MODULE ${MODULE_UNPARSED_ARGUMENTS})
  # Two modules of the same .so file must not share variables, but the loader would share GNU_UNIQUE symbols.
  target_compile_options(${name} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-gnu-unique>)
  target_link_libraries(${name} PRIVATE takt_component ${MODULE_TYPES})
  set_target_properties(${name} PROPERTIES PREFIX "" SUFFIX ".so" LIBRARY_OUTPUT_DIRECTORY ${TAKT_COMPONENT_DIR}
                        UNITY_BUILD OFF)
  if(COMMAND takt_precompile)  # only Takt's own build has this command
    set_target_properties(${name} PROPERTIES DEFINE_SYMBOL "")  # otherwise the targets would have different options
    takt_precompile(${name} component takt/component.hpp)
  endif()
endfunction()

function(takt_add_process name)
  cmake_parse_arguments(MODULE "" "" "TYPES" ${ARGN})
  add_executable(${name} ${MODULE_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PRIVATE takt_process ${MODULE_TYPES})
  set_target_properties(${name} PROPERTIES SUFFIX ".exe" RUNTIME_OUTPUT_DIRECTORY ${TAKT_COMPONENT_DIR} UNITY_BUILD OFF)
endfunction()

# The tests are named servo.SUITE.TEST in CTest. A process module is compiled a second time for its tests, as a library whose main() the
# tests call. Call this function after all other commands for the component. Without GoogleTest (Debian: libgtest-dev), it builds nothing.
function(takt_add_component_test name)
  if(NOT TARGET ${name})
    message(FATAL_ERROR "takt_add_component_test(${name}): call takt_add_component(${name}) or takt_add_process(${name}) first")
  endif()
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
endfunction()
