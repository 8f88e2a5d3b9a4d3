#include <takt/core/check.hpp>

#include <cstdio>
#include <cstdlib>

namespace takt {

void check_failed(const char* condition, const char* file, int line) noexcept {
  std::fprintf(stderr, "%s:%d: takt: internal error: %s does not hold\n", file, line, condition);
  std::abort();
}

}  // namespace takt
