# Builds for arm64 on another architecture: CMAKE_TOOLCHAIN_FILE=cmake/arm64.cmake. tools/on debian13-arm64 sets this variable.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_C_COMPILER ${CMAKE_LIBRARY_ARCHITECTURE}-gcc)
set(CMAKE_CXX_COMPILER ${CMAKE_LIBRARY_ARCHITECTURE}-g++)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64)  # the build runs takt, which writes the manual pages
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
