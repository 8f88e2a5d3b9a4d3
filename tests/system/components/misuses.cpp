// A periodic program whose first argument, or the environment, selects how it misuses the functions of
// <takt/process.h>.
#include <takt/process.hpp>

#include <csignal>
#include <cstdlib>
#include <memory>
#include <string_view>

#include <unistd.h>

#include "sample.hpp"

int main(int argc, char* argv[]) {
  const std::string_view how = argc > 1 ? argv[1] : "";
  if (std::getenv("TAKT_TEST_CRASH") != nullptr) std::raise(SIGSEGV);
  if (how == "daemon" && ::daemon(0, 0) != 0) return 2;
  if (how == "fork" && ::fork() != 0) return 0;
  initPeriodExe();
  if (how == "late port") static_cast<void>(std::make_unique<takt::OutPort<samples::Count>>("late"));
  if (how == "late daemon" && ::daemon(0, 1) != 0) return 2;
  while (true) waitPeriod();
}
