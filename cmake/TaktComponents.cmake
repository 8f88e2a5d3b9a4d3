# For authors.
#
#   takt_add_component(servo servo.cpp ...)   a thread module: servo.so
#   takt_add_process(vision vision.cpp ...)   a process module: vision.exe
#
# Both are built into ${TAKT_COMPONENT_DIR}, by default the folder `components` of the build tree.

set(TAKT_COMPONENT_DIR ${CMAKE_BINARY_DIR}/components CACHE PATH "Where components are built to")

function(takt_add_component name)
  add_library(${name} MODULE ${ARGN})
  # A second module of the same file gets its own copy of the file's variables; GNU_UNIQUE symbols would be shared.
  target_compile_options(${name} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-gnu-unique>)
  target_link_libraries(${name} PRIVATE takt_component)
  set_target_properties(${name} PROPERTIES PREFIX "" SUFFIX ".so" LIBRARY_OUTPUT_DIRECTORY ${TAKT_COMPONENT_DIR})
endfunction()

function(takt_add_process name)
  add_executable(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE takt_process)
  set_target_properties(${name} PROPERTIES SUFFIX ".exe" RUNTIME_OUTPUT_DIRECTORY ${TAKT_COMPONENT_DIR})
endfunction()
