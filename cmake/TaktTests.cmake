# takt_discover_tests(program [PREFIX text] [TIMEOUT seconds] [PROPERTIES ...]) registers the tests of a GoogleTest program in CTest.
#
# Each TEST becomes one CTest test. Under sanitizers, the whole program becomes one test, named asan.PROGRAM or tsan.PROGRAM, because the
# start of a process under AddressSanitizer takes longer than most tests. There, the tests of the ready-made components have the label `full`,
# so that only tools/test --full runs them.

include(GoogleTest)
# Turns off address space randomization, because ThreadSanitizer does not support the memory layout of newer kernels.
if(TAKT_SANITIZE STREQUAL "thread")
  find_program(SETARCH setarch REQUIRED)
  set(TAKT_RUN_FIXED ${SETARCH} ${CMAKE_HOST_SYSTEM_PROCESSOR} --addr-no-randomize)
endif()

function(takt_discover_tests program)
  cmake_parse_arguments(TESTS "" "PREFIX;TIMEOUT" "PROPERTIES" ${ARGN})
  if(NOT TAKT_SANITIZE)
    if(TESTS_PREFIX)
      list(PREPEND TESTS_PREFIX TEST_PREFIX)
    endif()
    gtest_discover_tests(${program} DISCOVERY_MODE PRE_TEST ${TESTS_PREFIX}
                         PROPERTIES TIMEOUT ${TESTS_TIMEOUT} ${TESTS_PROPERTIES})
    return()
  endif()
  get_filename_component(preset ${CMAKE_BINARY_DIR} NAME)
  set(labels ${preset})
  if(CMAKE_CURRENT_SOURCE_DIR MATCHES "^${CMAKE_SOURCE_DIR}/components(/|$)")
    list(APPEND labels full)
  endif()
  add_test(NAME ${preset}.${program} COMMAND ${TAKT_RUN_FIXED} $<TARGET_FILE:${program}> --gtest_brief=1)
  set_tests_properties(${preset}.${program} PROPERTIES TIMEOUT 1800 COST 20 LABELS "${labels}" ${TESTS_PROPERTIES})
endfunction()
