// Names the component that a test program tests. Each test program has a generated source file that includes
// only this header, so the header is separate from testing.hpp.
#pragma once

namespace takt::testing::detail {

/// Sets the file of the tested component. takt_add_component_test() generates one such object in each test
/// program, constructed before main().
struct TestedFile {
  /// `path`: the .so of a thread module, or the .exe.so of a process module.
  explicit TestedFile(const char* path);
};

}  // namespace takt::testing::detail
