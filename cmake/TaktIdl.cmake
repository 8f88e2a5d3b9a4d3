# For authors.
#
#   takt_add_idl(types motion.idl line.idl ...)     the types of ports, from IDL
#   takt_add_component(servo servo.cpp TYPES types)
#
# makes the library `types`. With it a source finds <motion.hpp>: the classes that fastddsgen makes of the file, and for each
# struct takt::PortType, which the ports of a component need. A source in C finds <motion_c.h>: plain structs, and for each a
# takt_type. Files that include one another go into one library. What is no
# type for a port ends the build with the file, the line and the field.

include(${CMAKE_CURRENT_LIST_DIR}/TaktWire.cmake)
find_package(Python3 3.9 COMPONENTS Interpreter REQUIRED)

function(takt_add_idl name)
  if(NOT ARGN)
    message(FATAL_ERROR "takt_add_idl(${name}) names no IDL file")
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
  # Ours first: it says everything that is wrong, in words. fastddsgen gets what it understands of that.
  add_custom_command(OUTPUT ${ours} ${headers} ${plain}
    COMMAND Python3::Interpreter ${script} --out ${folder} ${files}
    DEPENDS ${files} ${script} ${modules} VERBATIM COMMENT "takt_idl.py ${ARGN}")
  takt_generate(classes ${plain} DIRECTORY ${folder})
  list(FILTER classes EXCLUDE REGEX "PubSubTypes")

  # Fast CDR calls a function of what is not there, for an empty sequence of arrays.
  set_source_files_properties(${classes} PROPERTIES COMPILE_OPTIONS -fno-sanitize=undefined)

  add_library(${name} STATIC ${classes} ${ours} ${headers})
  # Two components may have types of one name from different files: nothing of them is shared.
  set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden UNITY_BUILD OFF)
  target_compile_options(${name} PRIVATE -w $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-gnu-unique>)
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_include_directories(${name} SYSTEM PUBLIC ${folder})
  target_link_libraries(${name} PUBLIC takt_types fastcdr)
endfunction()
