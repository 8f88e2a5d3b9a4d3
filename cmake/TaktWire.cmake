# takt_generate(OUT idl/takt.idl DIRECTORY out/takt/wire) generates sources from IDL files with fastddsgen, and sets OUT to their paths. Use
# takt_generate() for the messages between nodes; takt_add_idl() generates the types of ports.
#
# - All files go into one call, because fastddsgen also generates the included files.
# - Temporary files get their own folder; otherwise fastddsgen uses fixed names in /tmp.
# - Without -replace, fastddsgen keeps an older output.
# - fastddsgen runs in the folder of the files, because it copies the given path of an included file into #include.
#
# The target takt_fastdds is Fast DDS, and TAKT_FASTDDS is its major version. Packages, targets and generated files have other names in other
# versions of Fast DDS and fastddsgen, so no other CMake file names them.

add_library(takt_fastdds INTERFACE)
find_package(fastdds 3 QUIET)  # finds fastcdr, too
if(fastdds_FOUND)
  set(TAKT_FASTDDS 3 CACHE INTERNAL "the major version of Fast DDS")
  target_link_libraries(takt_fastdds INTERFACE fastdds)
  # Fast DDS brings this target, whose definitions change nothing on Linux, but prevent sharing precompiled headers with other targets.
  set_target_properties(tinyxml2::tinyxml2 PROPERTIES INTERFACE_COMPILE_DEFINITIONS "")
else()
  set(TAKT_FASTDDS 2 CACHE INTERNAL "the major version of Fast DDS")
  find_package(fastrtps 2.9 REQUIRED GLOBAL)
  target_link_libraries(takt_fastdds INTERFACE fastrtps)
endif()
target_compile_definitions(takt_fastdds INTERFACE TAKT_FASTDDS=${TAKT_FASTDDS})  # for dds/src/fast_dds.hpp
find_program(FASTDDSGEN fastddsgen REQUIRED)

function(takt_generate out)
  cmake_parse_arguments(ARG "" "DIRECTORY" "" ${ARGN})
  set(outputs)
  set(files)
  set(names)
  set(folders)
  foreach(idl IN LISTS ARG_UNPARSED_ARGUMENTS)
    get_filename_component(file ${idl} ABSOLUTE)
    get_filename_component(stem ${idl} NAME_WE)
    list(APPEND files ${file})
    get_filename_component(folder ${file} DIRECTORY)
    list(APPEND names ${stem}.idl)
    list(APPEND folders ${folder})
    list(APPEND outputs ${ARG_DIRECTORY}/${stem}.h ${ARG_DIRECTORY}/${stem}.cxx ${ARG_DIRECTORY}/${stem}PubSubTypes.h
         ${ARG_DIRECTORY}/${stem}PubSubTypes.cxx)
  endforeach()
  list(REMOVE_DUPLICATES folders)
  list(LENGTH folders n)
  if(NOT n EQUAL 1)
    message(FATAL_ERROR "takt_generate: ${ARG_UNPARSED_ARGUMENTS} are not in the same folder")
  endif()
  file(MAKE_DIRECTORY ${ARG_DIRECTORY})
  string(MD5 scratch "${ARG_DIRECTORY}")
  set(scratch ${CMAKE_BINARY_DIR}/idl/${scratch})
  if(TAKT_FASTDDS EQUAL 2)
    set(generate ${FASTDDSGEN} -replace -cs -t ${scratch} -d ${ARG_DIRECTORY} ${names})
  else()
    set(generate ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/fastddsgen4.sh ${FASTDDSGEN} ${scratch} ${ARG_DIRECTORY} ${names})
    list(APPEND files ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/fastddsgen4.sh)
  endif()
  add_custom_command(OUTPUT ${outputs}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${scratch}
    # The output is long, so it is shown only on failure.
    COMMAND sh -c "\"$@\" >'${scratch}/log' 2>&1 || { cat '${scratch}/log' >&2; exit 1; }" sh
            ${generate}
    DEPENDS ${files} WORKING_DIRECTORY ${folders} VERBATIM COMMENT "fastddsgen ${names}")
  set(${out} ${outputs} PARENT_SCOPE)
endfunction()
