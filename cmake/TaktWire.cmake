# takt_generate(OUT idl/takt.idl DIRECTORY out/takt/wire): the sources that fastddsgen makes of IDL files.
#
# All files in one call, because included ones are generated too; a folder for its temporary files of its own, because it
# uses fixed names in /tmp otherwise; -replace, because else it leaves an older output as it is; from the files' folder,
# because it writes the path of an included file into #include as it was given.

find_package(fastcdr REQUIRED)
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
    message(FATAL_ERROR "takt_generate: ${ARG_UNPARSED_ARGUMENTS} are not in one folder")
  endif()
  file(MAKE_DIRECTORY ${ARG_DIRECTORY})
  string(MD5 scratch "${ARG_DIRECTORY}")
  set(scratch ${CMAKE_BINARY_DIR}/idl/${scratch})
  add_custom_command(OUTPUT ${outputs}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${scratch}
    # It says much; that is shown when it fails.
    COMMAND sh -c "\"$@\" >'${scratch}/log' 2>&1 || { cat '${scratch}/log' >&2; exit 1; }" sh
            ${FASTDDSGEN} -replace -cs -t ${scratch} -d ${ARG_DIRECTORY} ${names}
    DEPENDS ${files} WORKING_DIRECTORY ${folders} VERBATIM COMMENT "fastddsgen ${names}")
  set(${out} ${outputs} PARENT_SCOPE)
endfunction()
