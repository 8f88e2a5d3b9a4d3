# CMake function for the authors of components:
#
#   takt_add_idl(types motion.idl line.idl ...)     builds the library `types` of port types from IDL
#   takt_add_component(servo servo.cpp TYPES types)
#
# C++ sources include <motion.hpp>, which contains a class for each struct, with the functions that fastddsgen generates, and takt::PortType
# for each class, which ports need. C sources include <motion_c.h>, which contains plain structs, each with a takt_type. Files that include
# each other belong in the same library. If ports do not support a type, the build fails with an error that names the file, the line and the
# cure.

find_package(Python3 3.9 COMPONENTS Interpreter REQUIRED)

# Fails with the message that `idl` does not exist. Suggests the file of this name among those of the ready-made components, or else the IDL
# files of the same folder.
function(takt_no_such_idl name idl)
  get_filename_component(folder ${idl} DIRECTORY)
  get_filename_component(folder "${folder}" ABSOLUTE)
  get_filename_component(file ${idl} NAME)
  file(GLOB found RELATIVE ${folder} ${folder}/*.idl)
  if(EXISTS "${TAKT_IDL_DIR}/${file}")
    set(cure "write \${TAKT_IDL_DIR}/${file}, or add the file")
  elseif(found)
    list(JOIN found ", " found)
    set(cure "the IDL files of ${folder} are: ${found}")
  else()
    set(cure "${folder} has no IDL file; the path is relative to the folder of CMakeLists.txt")
  endif()
  message(FATAL_ERROR "takt_add_idl(${name}): there is no file ${idl}; ${cure}")
endfunction()

function(takt_add_idl name)
  takt_check_name(takt_add_idl ${name} STEM_types)
  get_property(languages GLOBAL PROPERTY ENABLED_LANGUAGES)
  if(NOT CXX IN_LIST languages)
    message(FATAL_ERROR "takt_add_idl(${name}): port types need C++, also for components in C; write LANGUAGES C CXX in the call of project()")
  endif()
  if(NOT ARGN)
    message(FATAL_ERROR "takt_add_idl(${name}) needs at least one IDL file")
  endif()
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/${name}_idl)
  set(script ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/takt_idl.py)
  file(GLOB modules CONFIGURE_DEPENDS ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/idl/*.py)
  set(files)
  set(sources)
  set(cure "write TYPES ${name} in the call of takt_add_component or takt_add_process")
  foreach(idl IN LISTS ARGN)
    get_filename_component(file ${idl} ABSOLUTE)
    get_filename_component(stem ${idl} NAME_WE)
    get_source_file_property(generated ${file} GENERATED)
    if(NOT EXISTS ${file} AND NOT generated)
      takt_no_such_idl(${name} ${idl})
    endif()
    foreach(header ${stem}.hpp ${stem}_c.h)  # a component that has the library in its TYPES includes the generated header instead
      file(CONFIGURE OUTPUT ${TAKT_HEADERS_WITHOUT_TYPES}/${header} CONTENT "#error <${header}> belongs to the library ${name}: ${cure}\n")
    endforeach()
    list(APPEND files ${file})
    list(APPEND sources ${folder}/${stem}.hpp ${folder}/${stem}_types.cpp ${folder}/${stem}_c.h ${folder}/${stem}_c.cpp)
  endforeach()
  add_custom_command(OUTPUT ${sources} COMMAND Python3::Interpreter ${script} --out ${folder} ${files}
                     DEPENDS ${files} ${script} ${modules} VERBATIM COMMENT "takt_idl.py ${ARGN}")

  set_property(GLOBAL APPEND PROPERTY TAKT_TYPES ${name})
  add_library(${name} STATIC ${sources})
  # Two components may have types of the same name from different files, so they must not share symbols.
  set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden UNITY_BUILD OFF)
  target_compile_options(${name} PRIVATE -w $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-gnu-unique>)
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_include_directories(${name} SYSTEM PUBLIC ${folder})
  target_link_libraries(${name} PUBLIC takt_types)
endfunction()
