// Records ports of the running cell to a file, until it is told to end.
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
  // Not by way of the static objects of Fast DDS, which sleep for a while in their destructors.
  std::fflush(nullptr);
  std::_Exit(status);
}
