// Records ports of the running cell to a file, until SIGTERM.
#include "properties.hpp"

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
  const auto options = takt::tool::parse_properties({argv + 1, argv + argc});
  if (!options) {
    std::fprintf(stderr, "%s\n", takt::to_text(options.problems()).c_str());
    return 1;
  }
  const int status = takt::recording::record(*options);
  // Ends without the destructors of Fast DDS's static objects, which sleep for a while.
  std::fflush(nullptr);
  std::_Exit(status);
}
