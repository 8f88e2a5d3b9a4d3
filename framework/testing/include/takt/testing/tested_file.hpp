// Which component a test program is about. Apart from testing.hpp because each program has a generated source
// that includes this alone.
#pragma once

namespace takt::testing::detail {

/// The file that takt_add_component_test() named; one in each program, before main().
struct TestedFile {
  explicit TestedFile(const char* path);
};

}  // namespace takt::testing::detail
