# The files that `cmake --install` copies, and the packages `takt` and `takt-dev` that cpack makes from these files. The target `installable`
# builds the files.
#
#   bin                    takt, takt-node
#   lib                    the libraries of components and programs
#   lib/takt               private files of the programs (os::private_directory()): takt-host, takt-keeper, libtakt_check.so, components/
#   lib/cmake/takt         find_package(takt), and the IDL compiler of takt_add_idl()
#   include/takt           the headers for authors of components
#   share/doc/takt         the manual, in the layout of the source tree: README.md, docs/, components/, ...
#   share/takt             the schema, the descriptors of deploy/, the IDL files
#
# All paths are relative to the program or to the CMake package file, so users can move the installed folder.

include(CMakePackageConfigHelpers)

set(lib ${CMAKE_INSTALL_LIBDIR})
set(private ${lib}/takt)
set(package ${lib}/cmake/takt)
set(share ${CMAKE_INSTALL_DATADIR}/takt)

# Sets `out` to those targets of a folder and its subfolders that a descriptor can use as components.
function(takt_modules_of directory out)
  set(modules)
  get_property(targets DIRECTORY ${directory} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(suffix ${target} SUFFIX)
    if(suffix MATCHES "^\\.(so|exe)$")
      list(APPEND modules ${target})
    endif()
  endforeach()
  get_property(folders DIRECTORY ${directory} PROPERTY SUBDIRECTORIES)
  foreach(folder IN LISTS folders)
    takt_modules_of(${folder} more)
    list(APPEND modules ${more})
  endforeach()
  set(${out} ${modules} PARENT_SCOPE)
endfunction()
takt_modules_of(${CMAKE_SOURCE_DIR}/components modules)
takt_modules_of(${CMAKE_SOURCE_DIR}/tools/takt/bench of_bench)
list(APPEND modules ${of_bench})

# Sets the rpath of a program: the relative path from the program to the libraries.
function(takt_finds_libraries_from folder)
  file(RELATIVE_PATH path /${folder} /${lib})
  string(REGEX REPLACE "/$" "" path "$ORIGIN/${path}")
  set_target_properties(${ARGN} PROPERTIES INSTALL_RPATH "${path}")
endfunction()
takt_finds_libraries_from(${CMAKE_INSTALL_BINDIR} takt takt-node)
takt_finds_libraries_from(${private} takt-host takt-keeper)
takt_finds_libraries_from(${private}/components ${modules})

install(TARGETS takt takt-node RUNTIME COMPONENT runtime)
install(TARGETS takt-host takt-keeper takt_check RUNTIME DESTINATION ${private} COMPONENT runtime
        LIBRARY DESTINATION ${private} COMPONENT runtime)
install(TARGETS ${modules} RUNTIME DESTINATION ${private}/components COMPONENT runtime
        LIBRARY DESTINATION ${private}/components COMPONENT runtime)
# The paper's module.xml uses this component under the name build/controller1.so.
install(FILES ${TAKT_COMPONENT_DIR}/build/controller1.so DESTINATION ${private}/components/build COMPONENT runtime)
install(TARGETS takt_component takt_process LIBRARY COMPONENT runtime NAMELINK_COMPONENT dev)
install(FILES config/takt.xsd config/grafana-takt.json DESTINATION ${share} COMPONENT runtime)
# The licence of dygraphs, which takt web contains.
install(FILES /usr/share/doc/libjs-dygraphs/copyright DESTINATION ${share} RENAME dygraphs-copyright COMPONENT runtime)
install(DIRECTORY deploy DESTINATION ${share} COMPONENT runtime)

install(DIRECTORY ${TAKT_PAGES}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT runtime)
install(DIRECTORY ${TAKT_PAGES}/completions DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion COMPONENT runtime)
# The manual is written at installation, so that no list of its pages is kept here.
install(CODE "
  execute_process(COMMAND \"${Python3_EXECUTABLE}\" cmake/manual.py . \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DOCDIR}\"
                  WORKING_DIRECTORY \"${CMAKE_SOURCE_DIR}\" COMMAND_ERROR_IS_FATAL ANY)" COMPONENT runtime)

# The API reference of the headers for authors. A doxygen warning, such as an undocumented function, fails the build.
find_package(Doxygen REQUIRED)
configure_file(docs/Doxyfile.in ${CMAKE_BINARY_DIR}/Doxyfile @ONLY)
file(GLOB_RECURSE documented CONFIGURE_DEPENDS framework/component/include/*.h* framework/testing/include/*.h* framework/core/include/*.hpp)
add_custom_command(OUTPUT ${CMAKE_BINARY_DIR}/api/html/index.html COMMAND Doxygen::doxygen ${CMAKE_BINARY_DIR}/Doxyfile
                   DEPENDS ${documented} ${CMAKE_BINARY_DIR}/Doxyfile docs/api.md VERBATIM COMMENT "API reference")
add_custom_target(api ALL DEPENDS ${CMAKE_BINARY_DIR}/api/html/index.html)
install(DIRECTORY ${CMAKE_BINARY_DIR}/api/html/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/api COMPONENT dev)

# The systemd unit contains the path of the program, so it is written at installation, when the prefix is known.
install(CODE "
  set(CMAKE_INSTALL_BINDIR ${CMAKE_INSTALL_BINDIR})
  file(MAKE_DIRECTORY \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/lib/systemd/system\")
  configure_file(\"${CMAKE_SOURCE_DIR}/config/takt-node@.service.in\"
                 \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/lib/systemd/system/takt-node@.service\" @ONLY)" COMPONENT runtime)

# The following files are for the authors of components.
install(TARGETS takt_core takt_lifecycle ARCHIVE COMPONENT dev)
install(TARGETS takt_testing LIBRARY COMPONENT dev)
takt_finds_libraries_from(${lib} takt_testing)
foreach(room core component testing)
  install(DIRECTORY framework/${room}/include/takt DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev)
endforeach()
install(FILES framework/lifecycle/include/takt/lifecycle/table.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/takt/lifecycle COMPONENT dev)
foreach(header activity flight layout link log_ring property_mailbox release_slot saved_state turn)  # the installed headers above include these headers
  install(FILES framework/channel/include/takt/channel/${header}.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/takt/channel COMPONENT dev)
endforeach()
install(FILES idl/basic.idl idl/line.idl idl/motion.idl idl/takt.idl DESTINATION ${share}/idl COMPONENT dev)

# find_package() also searches the top of the build tree if the build tree's bin folder is in PATH. The package file there therefore reports
# that it is unsuitable, so that find_package() continues. The real package file is in a subfolder.
configure_package_config_file(cmake/takt-config.cmake.in ${CMAKE_BINARY_DIR}/package/takt-config.cmake INSTALL_DESTINATION ${package}
  PATH_VARS CMAKE_INSTALL_INCLUDEDIR CMAKE_INSTALL_LIBDIR CMAKE_INSTALL_DATADIR)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/takt-config-version.cmake COMPATIBILITY SameMinorVersion)
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/takt-config.cmake CONTENT "# Not installed.\n")
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/takt-config-version.cmake @ONLY CONTENT [[
set(PACKAGE_VERSION "none: this is a build tree; install it, as docs/install.md says: cmake --install @CMAKE_BINARY_DIR@ --prefix FOLDER, and name FOLDER in CMAKE_PREFIX_PATH")
set(PACKAGE_VERSION_UNSUITABLE TRUE)
]])
install(FILES ${CMAKE_BINARY_DIR}/package/takt-config.cmake ${CMAKE_BINARY_DIR}/package/takt-config-version.cmake cmake/TaktComponents.cmake
              cmake/TaktIdl.cmake DESTINATION ${package} COMPONENT dev)
install(PROGRAMS cmake/takt_idl.py DESTINATION ${package} COMPONENT dev)
install(DIRECTORY cmake/idl DESTINATION ${package} COMPONENT dev FILES_MATCHING PATTERN *.py)

add_custom_target(installable DEPENDS takt_pages api takt takt-node takt-host takt-keeper takt_check takt_component takt_process takt_testing takt_core takt_lifecycle ${modules})

include(TaktPackages)
