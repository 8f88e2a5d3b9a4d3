# For authors.
#
#   takt_add_component(servo servo.cpp ... [TYPES types ...])   a thread module: servo.so
#   takt_add_process(vision vision.cpp ... [TYPES types ...])   a process module: vision.exe
#
# Both are built into ${TAKT_COMPONENT_DIR}, by default the folder `components` of the build tree. The types of their ports are
# libraries of takt_add_idl().

set(TAKT_COMPONENT_DIR ${CMAKE_BINARY_DIR}/components CACHE PATH "Where components are built to")

function(takt_add_component name)
  cmake_parse_arguments(MODULE "" "" "TYPES" ${ARGN})
  add_library(${name} MODULE ${MODULE_UNPARSED_ARGUMENTS})
  # A second module of the same file gets its own copy of the file's variables; GNU_UNIQUE symbols would be shared.
  target_compile_options(${name} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-gnu-unique>)
  target_link_libraries(${name} PRIVATE takt_component ${MODULE_TYPES})
  set_target_properties(${name} PROPERTIES PREFIX "" SUFFIX ".so" LIBRARY_OUTPUT_DIRECTORY ${TAKT_COMPONENT_DIR})
endfunction()

function(takt_add_process name)
  cmake_parse_arguments(MODULE "" "" "TYPES" ${ARGN})
  add_executable(${name} ${MODULE_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PRIVATE takt_process ${MODULE_TYPES})
  set_target_properties(${name} PROPERTIES SUFFIX ".exe" RUNTIME_OUTPUT_DIRECTORY ${TAKT_COMPONENT_DIR})
endfunction()
