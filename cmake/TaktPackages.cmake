# Debian packages: `cpack -G DEB` in the build folder makes takt and takt-dev.

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME takt)
set(CPACK_PACKAGE_VENDOR "The Takt authors")
set(CPACK_PACKAGE_CONTACT "The Takt authors <takt@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "real-time component middleware for industrial cells")
set(CPACK_COMPONENTS_ALL runtime dev)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
# The systemd unit must contain the path of the installed program, not that of the folder in which cpack assembles the package.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME takt)
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION
"Runs cells of robots, soft PLCs, sensors and stations. A cell consists of
components that are described in XML, deployed over DDS, run in real time
and monitored. This package contains the programs takt and takt-node, and
the ready-made components.")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "bash-completion, stress-ng")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME takt-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_DESCRIPTION
"Files for building components: the headers, the CMake package with
takt_add_component() and takt_add_process(), and the IDL compiler of
takt_add_idl() for the types of ports.")
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
    "takt (= ${PROJECT_VERSION}), g++, cmake (>= 3.25), python3 (>= 3.9)")
set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS "libgtest-dev, libgmock-dev")

include(CPack)
