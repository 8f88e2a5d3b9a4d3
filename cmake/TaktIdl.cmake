# CMake function for the authors of components:
#
#   takt_add_idl(types motion.idl line.idl ...)     builds the library `types` of port types from IDL
#   takt_add_component(servo servo.cpp TYPES types)
#
# C++ sources include <motion.hpp>. It contains the classes that fastddsgen generates, and takt::PortType for each struct, which
# ports need. C sources include <motion_c.h>. It contains plain structs, each with a takt_type. Files that include each other belong in the
# same library. If ports do not support a type, the build fails with an error that names the file, the line and the field.

include(${CMAKE_CURRENT_LIST_DIR}/TaktWire.cmake)
find_package(Python3 3.9 COMPONENTS Interpreter REQUIRED)

function(takt_add_idl name)
  if(NOT ARGN)
    message(FATAL_ERROR "takt_add_idl(${name}) needs at least one IDL file")
  endif()
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/${name}_idl)
  set(script ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/takt_idl.py)
  file(GLOB modules CONFIGURE_DEPENDS ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/idl/*.py)
  set(files)
  set(ours)
  set(headers)
  set(plain)
  foreach(idl IN LISTS ARGN)
    get_filename_component(file ${idl} ABSOLUTE)
    get_filename_component(stem ${idl} NAME_WE)
    list(APPEND files ${file})
    list(APPEND ours ${folder}/${stem}_types.cpp ${folder}/${stem}_c.cpp)
    list(APPEND headers ${folder}/${stem}.hpp ${folder}/${stem}_c.h)
    list(APPEND plain ${folder}/plain/${stem}.idl)
  endforeach()
  # takt_idl.py runs before fastddsgen. It reports all problems, and writes the IDL that fastddsgen understands.
  add_custom_command(OUTPUT ${ours} ${headers} ${plain}
    COMMAND Python3::Interpreter ${script} --out ${folder} ${files}
    DEPENDS ${files} ${script} ${modules} VERBATIM COMMENT "takt_idl.py ${ARGN}")
  takt_generate(classes ${plain} DIRECTORY ${folder})
  list(FILTER classes EXCLUDE REGEX "PubSubTypes")

  # For an empty sequence of arrays, Fast CDR calls a member function through an invalid reference.
  set_source_files_properties(${classes} PROPERTIES COMPILE_OPTIONS -fno-sanitize=undefined)

  add_library(${name} STATIC ${classes} ${ours} ${headers})
  # Two components may have types of the same name from different files, so they must not share symbols.
  set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden UNITY_BUILD OFF)
  target_compile_options(${name} PRIVATE -w $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-gnu-unique>)
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_include_directories(${name} SYSTEM PUBLIC ${folder})
  target_link_libraries(${name} PUBLIC takt_types fastcdr)
endfunction()
