# takt_generate(OUT idl/takt.idl DIRECTORY out/takt/wire): the sources that fastddsgen makes of IDL files.
#
# All files in one call, because included ones are generated too; a folder for its temporary files of its own, because it
# uses fixed names in /tmp otherwise; -replace, because else it leaves an older output as it is.

find_package(fastcdr REQUIRED)
find_program(FASTDDSGEN fastddsgen REQUIRED)

function(takt_generate out)
  cmake_parse_arguments(ARG "" "DIRECTORY" "" ${ARGN})
  set(outputs)
  set(files)
  foreach(idl IN LISTS ARG_UNPARSED_ARGUMENTS)
    get_filename_component(file ${idl} ABSOLUTE)
    get_filename_component(stem ${idl} NAME_WE)
    list(APPEND files ${file})
    list(APPEND outputs ${ARG_DIRECTORY}/${stem}.h ${ARG_DIRECTORY}/${stem}.cxx ${ARG_DIRECTORY}/${stem}PubSubTypes.h
         ${ARG_DIRECTORY}/${stem}PubSubTypes.cxx)
  endforeach()
  file(MAKE_DIRECTORY ${ARG_DIRECTORY})
  string(MD5 scratch "${ARG_DIRECTORY}")
  add_custom_command(OUTPUT ${outputs}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${CMAKE_BINARY_DIR}/idl/${scratch}
    COMMAND ${FASTDDSGEN} -replace -cs -t ${CMAKE_BINARY_DIR}/idl/${scratch} -d ${ARG_DIRECTORY} ${files} > ${CMAKE_BINARY_DIR}/idl/${scratch}/log
    DEPENDS ${files} VERBATIM COMMENT "fastddsgen ${ARG_UNPARSED_ARGUMENTS}")
  set(${out} ${outputs} PARENT_SCOPE)
endfunction()
