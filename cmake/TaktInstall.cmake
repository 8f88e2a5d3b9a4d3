# What `cmake --install` copies, and the packages `takt` and `takt-dev` that cpack makes of it. The target `installable` builds it.
#
#   bin                    takt, takt-node
#   lib                    what components and programs link with
#   lib/takt               what the programs look up: takt-host, libtakt_check.so (os::private_directory()); components/
#   lib/cmake/takt         find_package(takt), and the compiler of takt_add_idl()
#   include/takt           what authors include
#   share/takt             the schema, the descriptors of deploy/, the IDL files
#
# Everything is found from the place of the program or of the package file, so that the folder may be moved.

include(CMakePackageConfigHelpers)

set(lib ${CMAKE_INSTALL_LIBDIR})
set(private ${lib}/takt)
set(package ${lib}/cmake/takt)
set(share ${CMAKE_INSTALL_DATADIR}/takt)

# The targets of a folder and of those below it that a descriptor can name.
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

# From where a program lies to the libraries.
function(takt_finds_libraries_from folder)
  file(RELATIVE_PATH path /${folder} /${lib})
  string(REGEX REPLACE "/$" "" path "$ORIGIN/${path}")
  set_target_properties(${ARGN} PROPERTIES INSTALL_RPATH "${path}")
endfunction()
takt_finds_libraries_from(${CMAKE_INSTALL_BINDIR} takt takt-node)
takt_finds_libraries_from(${private} takt-host)
takt_finds_libraries_from(${private}/components ${modules})

install(TARGETS takt takt-node RUNTIME COMPONENT runtime)
install(TARGETS takt-host takt_check RUNTIME DESTINATION ${private} COMPONENT runtime
        LIBRARY DESTINATION ${private} COMPONENT runtime)
install(TARGETS ${modules} RUNTIME DESTINATION ${private}/components COMPONENT runtime
        LIBRARY DESTINATION ${private}/components COMPONENT runtime)
install(TARGETS takt_component takt_process LIBRARY COMPONENT runtime NAMELINK_COMPONENT dev)
install(FILES config/takt.xsd config/grafana-takt.json DESTINATION ${share} COMPONENT runtime)
install(DIRECTORY deploy DESTINATION ${share} COMPONENT runtime)

install(DIRECTORY ${TAKT_PAGES}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT runtime)
install(DIRECTORY ${TAKT_PAGES}/completions DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion COMPONENT runtime)
install(FILES README.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime PATTERN reports EXCLUDE)
file(GLOB pages RELATIVE ${CMAKE_SOURCE_DIR}/components CONFIGURE_DEPENDS components/*/README.md)
foreach(page IN LISTS pages)
  get_filename_component(component ${page} DIRECTORY)
  install(FILES components/${page} DESTINATION ${CMAKE_INSTALL_DOCDIR}/components RENAME ${component}.md COMPONENT runtime)
endforeach()

# The unit names the program by the prefix that is chosen when it is installed.
install(CODE "
  set(CMAKE_INSTALL_BINDIR ${CMAKE_INSTALL_BINDIR})
  file(MAKE_DIRECTORY \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/lib/systemd/system\")
  configure_file(\"${CMAKE_SOURCE_DIR}/config/takt-node@.service.in\"
                 \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/lib/systemd/system/takt-node@.service\" @ONLY)" COMPONENT runtime)

# For authors.
install(TARGETS takt_core takt_lifecycle ARCHIVE COMPONENT dev)
install(TARGETS takt_testing LIBRARY COMPONENT dev)
takt_finds_libraries_from(${lib} takt_testing)
foreach(room core component testing)
  install(DIRECTORY framework/${room}/include/takt DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev)
endforeach()
install(FILES framework/lifecycle/include/takt/lifecycle/table.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/takt/lifecycle COMPONENT dev)
foreach(header activity flight layout link release_slot saved_state)  # the headers above include these
  install(FILES framework/channel/include/takt/channel/${header}.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/takt/channel COMPONENT dev)
endforeach()
install(FILES idl/basic.idl idl/line.idl idl/motion.idl idl/takt.idl DESTINATION ${share}/idl COMPONENT dev)

# Not at the top of the build tree, where find_package() looks once its bin is in PATH: there it finds why not, and looks on.
configure_package_config_file(cmake/takt-config.cmake.in ${CMAKE_BINARY_DIR}/package/takt-config.cmake INSTALL_DESTINATION ${package}
  PATH_VARS CMAKE_INSTALL_INCLUDEDIR CMAKE_INSTALL_LIBDIR CMAKE_INSTALL_DATADIR)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/takt-config-version.cmake COMPATIBILITY SameMinorVersion)
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/takt-config.cmake CONTENT "# Not installed.\n")
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/takt-config-version.cmake @ONLY CONTENT [[
set(PACKAGE_VERSION "none: this is a build tree; install it, as docs/install.md says: cmake --install @CMAKE_BINARY_DIR@ --prefix FOLDER, and name FOLDER in CMAKE_PREFIX_PATH")
set(PACKAGE_VERSION_UNSUITABLE TRUE)
]])
install(FILES ${CMAKE_BINARY_DIR}/package/takt-config.cmake ${CMAKE_BINARY_DIR}/package/takt-config-version.cmake cmake/TaktComponents.cmake
              cmake/TaktIdl.cmake cmake/TaktWire.cmake DESTINATION ${package} COMPONENT dev)
install(PROGRAMS cmake/takt_idl.py DESTINATION ${package} COMPONENT dev)
install(DIRECTORY cmake/idl DESTINATION ${package} COMPONENT dev FILES_MATCHING PATTERN *.py)

add_custom_target(installable DEPENDS takt_pages takt takt-node takt-host takt_check takt_component takt_process takt_testing takt_core takt_lifecycle ${modules})

include(TaktPackages)
